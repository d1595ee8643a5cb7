/* SPDX-License-Identifier: MIT */
/* The schema and its migrations. A store's schema version (PRAGMA user_version) is the number of
 * steps it has been through. A released step is never edited; a change is a new step.
 *
 * scene             a document, stored once per content; removed with the last job that names it
 * job, view, batch  the work and its progress
 * pixels            the pixels of a render batch; one row for each that is done
 * artefact          pictures and reports; view -1: made from all views. checksum is that of data,
 *                   NULL in rows from before schema 7
 * idempotency       clients' keys, hashes of their bodies, and the answers. They outlive their
 *                   jobs: deleting a job does not revoke what its client was promised. The row with
 *                   the empty key belongs to the trial writes
 * meta              what the store knows about itself (meta.c)
 * removed           jobs that were removed, with their client and statistics, which stay
 * large_object      a value of an artefact or of pixels that is written in several transactions, in
 *                   parts; its row then has no data of its own
 * cached            artefacts that may be dropped, because they can be made again; when each was
 *                   last used
 * peer              shares: what a client was served at a priority
 * attribute         what lists of jobs are filtered by: of a job its `name`, and for each label
 *                   `label:` and its key
 * worker            the list of workers, for readers, and the inode of the file that each locked
 *
 * Numbers of jobs and batches are never reused (AUTOINCREMENT): a claim names a batch by number and
 * attempt, and must not fit another batch after a delete.
 *
 * large_object.expires_ms  NULL: a row has it. 0: none has it any more. Else it is being written,
 *                      and may be removed from then on, unless more of it comes before
 * view.open_batches    commits count these two down, so that a commit costs the same in a job of
 * job.open_views       many batches as in a job of few
 * job.deaths           workers lost over the job since its last commit
 * job.charges          those of them that crashed by the job's fault
 * job.paused_until_ms  until then other jobs go first
 * job.spent_us         how long workers have worked on the job, by their monotonic clocks
 * job.work             the share of the job's expected work that is done, in billionths: the sum of
 *                      batch.work
 * job.told_us          what spent_us was when that was told, by a commit or between
 * job.told_elapsed_us  what elapsed_us was then
 * job.cost_map         where its work lies, until it ends (render/cost_map.h); NULL: not known
 * job.elapsed_us       the time since the submit, up to the moment of moment_boot, moment_us (of
 *                      pen_clock_moment) and moment_ms (of the store's clock)
 * job.queue_us         what elapsed_us was when the job began
 * batch.commit_us      how long its worker waited for its commit
 * job.removed_ms       when it was removed; its rows go in slices, the job's own row last
 * job.client           its owner; job.peer, batch.peer: the share that they belong to
 * peer.jobs            the unfinished jobs
 * peer.served_us       the time that workers have worked for it, so far as it is remembered
 * peer.balance_us      how much more of it went to its oldest jobs than to others
 * level.virtual_us     the virtual time of the peers of a priority
 * peer.waiting_since_ms when it was served last, or began to wait
 * batch.spent_us       the part of the job's time that was spent under the batch's present attempt
 * batch.work           the part of job.work that was last told of the batch
 * batch.quarantined    a worker was lost while it held the batch
 * batch.revision       the revision that the commit gave the job; a reader that knows an older one
 *                      asks for the commits since */
#include "store/sqlite/sqlite.h"

#include <stdio.h>

#include "store/states.h"

static const char step_1[] =
    "CREATE TABLE scene ("
    " id INTEGER PRIMARY KEY,"
    " sha256 BLOB NOT NULL UNIQUE CHECK (length(sha256) = 32),"
    " document BLOB NOT NULL"
    ") STRICT;"
    "CREATE TABLE job ("
    " number INTEGER PRIMARY KEY AUTOINCREMENT,"
    " id TEXT NOT NULL UNIQUE,"
    " state INTEGER NOT NULL DEFAULT 0 CHECK (state BETWEEN 0 AND 4),"
    " revision INTEGER NOT NULL DEFAULT 1,"
    " kind TEXT NOT NULL,"
    " scene INTEGER NOT NULL REFERENCES scene(id),"
    " priority INTEGER NOT NULL,"
    " max_attempts INTEGER NOT NULL,"
    " charges INTEGER NOT NULL DEFAULT 0,"
    " timeout_ms INTEGER NOT NULL,"
    " created_ms INTEGER NOT NULL,"
    " started_ms INTEGER NOT NULL DEFAULT 0,"
    " finished_ms INTEGER NOT NULL DEFAULT 0,"
    " updated_ms INTEGER NOT NULL,"
    " done_pixels INTEGER NOT NULL DEFAULT 0 CHECK (done_pixels <= total_pixels),"
    " total_pixels INTEGER NOT NULL,"
    " open_views INTEGER NOT NULL CHECK (open_views >= 0),"
    " request TEXT NOT NULL,"
    " error TEXT"
    ") STRICT;"
    "CREATE INDEX job_by_state ON job(state, number);"
    "CREATE INDEX job_by_scene ON job(scene);"
    "CREATE TABLE view ("
    " job INTEGER NOT NULL REFERENCES job(number) ON DELETE CASCADE,"
    " view INTEGER NOT NULL,"
    " name TEXT NOT NULL,"
    " width INTEGER NOT NULL,"
    " height INTEGER NOT NULL,"
    " batches INTEGER NOT NULL,"
    " open_batches INTEGER NOT NULL CHECK (open_batches BETWEEN 0 AND batches),"
    " PRIMARY KEY (job, view)"
    ") STRICT, WITHOUT ROWID;"
    "CREATE TABLE batch ("
    " id INTEGER PRIMARY KEY AUTOINCREMENT,"
    " job INTEGER NOT NULL,"
    " view INTEGER NOT NULL,"
    " kind INTEGER NOT NULL,"
    " first_tile INTEGER NOT NULL,"
    " tile_count INTEGER NOT NULL,"
    " pixels INTEGER NOT NULL,"
    " priority INTEGER NOT NULL,"
    " state INTEGER NOT NULL DEFAULT 0 CHECK (state BETWEEN 0 AND 3),"
    " attempt INTEGER NOT NULL DEFAULT 0,"
    " worker TEXT,"
    " lease_until_ms INTEGER,"
    " done_ms INTEGER,"
    " stats TEXT,"
    " FOREIGN KEY (job, view) REFERENCES view(job, view) ON DELETE CASCADE,"
    " CHECK ((state = 1) = (worker IS NOT NULL)),"
    " CHECK ((state = 1) = (lease_until_ms IS NOT NULL)),"
    " CHECK ((state = 2) = (done_ms IS NOT NULL))"
    ") STRICT;"
    "CREATE INDEX batch_by_job ON batch(job, view);"
    "CREATE INDEX batch_open ON batch(priority DESC, job, id) WHERE state = 0;"
    "CREATE INDEX batch_leased ON batch(lease_until_ms) WHERE state = 1;"
    "CREATE TABLE pixels ("
    " batch INTEGER PRIMARY KEY REFERENCES batch(id) ON DELETE CASCADE,"
    " data BLOB NOT NULL"
    ") STRICT;"
    "CREATE TABLE artefact ("
    " id INTEGER PRIMARY KEY,"
    " job INTEGER NOT NULL REFERENCES job(number) ON DELETE CASCADE,"
    " view INTEGER NOT NULL,"
    " layer TEXT NOT NULL,"
    " format TEXT NOT NULL,"
    " data BLOB NOT NULL,"
    " UNIQUE (job, view, layer, format)"
    ") STRICT;"
    "CREATE TABLE idempotency ("
    " key TEXT PRIMARY KEY,"
    " body_sha256 BLOB NOT NULL CHECK (length(body_sha256) = 32),"
    " answer TEXT NOT NULL,"
    " created_ms INTEGER NOT NULL"
    ") STRICT, WITHOUT ROWID;"
    "CREATE INDEX idempotency_by_age ON idempotency(created_ms);";

/* Lost workers: the batches they held, and the consequences for the jobs. */
static const char step_2[] =
    "ALTER TABLE job ADD COLUMN deaths INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE job ADD COLUMN rest_until_ms INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE batch ADD COLUMN suspect INTEGER NOT NULL DEFAULT 0 CHECK (suspect IN (0, 1));";

/* The revision that a batch's commit gave its job. Jobs of earlier schemas had revision 1 when
 * submitted, 2 when started, and one more after each commit. */
static const char step_3[] =
    "ALTER TABLE batch ADD COLUMN revision INTEGER;"
    "UPDATE batch SET revision = past.revision FROM (SELECT id, 2 + row_number()"
    " OVER (PARTITION BY job ORDER BY done_ms, id) AS revision FROM batch WHERE state = 2) AS past"
    " WHERE batch.id = past.id;"
    "CREATE INDEX batch_by_revision ON batch(job, revision) WHERE revision IS NOT NULL;";

/* The list of workers. */
static const char step_4[] = "CREATE TABLE worker ("
                             " name TEXT PRIMARY KEY,"
                             " threads INTEGER NOT NULL,"
                             " lease_ms INTEGER NOT NULL,"
                             " started_ms INTEGER NOT NULL,"
                             " seen_ms INTEGER NOT NULL"
                             ") STRICT, WITHOUT ROWID;";

/* No change of tables. From here on pixels may have the form 0x02 (store/pixels.c), which builds of
 * earlier schemas cannot read. */
static const char step_5[] = "";

/* No change of tables. From here on there may be batches of kind 2, studies, which builds of
 * earlier schemas would take for assemble batches. */
static const char step_6[] = "";

/* Checksums of artefacts; earlier artefacts have none. */
static const char step_7[] = "ALTER TABLE artefact ADD COLUMN sum INTEGER;";

/* Plainer names of columns; workers with random ids instead of names made of host and process
 * (earlier workers have ended, so their rows are dropped); a constraint against a second assemble
 * batch. */
static const char step_8[] =
    "ALTER TABLE batch RENAME COLUMN suspect TO quarantined;"
    "ALTER TABLE job RENAME COLUMN rest_until_ms TO paused_until_ms;"
    "ALTER TABLE artefact RENAME COLUMN sum TO checksum;"
    "CREATE UNIQUE INDEX batch_assemble ON batch(job, view) WHERE kind = 1;"
    "DROP TABLE worker;"
    "CREATE TABLE worker ("
    " id TEXT PRIMARY KEY,"
    " host TEXT NOT NULL,"
    " pid INTEGER NOT NULL,"
    " threads INTEGER NOT NULL,"
    " lease_ms INTEGER NOT NULL,"
    " started_ms INTEGER NOT NULL,"
    " seen_ms INTEGER NOT NULL"
    ") STRICT, WITHOUT ROWID;";

/* The inode of the file in which a worker holds its lock (workers.c). */
static const char step_9[] = "ALTER TABLE worker ADD COLUMN lock_file INTEGER;";

/* What a worker expects the job's rendering to take. From here on studies may be of other kinds
 * than benchmarks, for which builds of earlier schemas would take them. */
static const char step_10[] = "ALTER TABLE job ADD COLUMN estimate_ms INTEGER NOT NULL DEFAULT 0;";

/* The time that workers spend on jobs, which timeouts are judged by. Of jobs that run already it
 * counts from now on. */
static const char step_11[] = "ALTER TABLE job ADD COLUMN spent_us INTEGER NOT NULL DEFAULT 0;"
                              "ALTER TABLE batch ADD COLUMN spent_us INTEGER NOT NULL DEFAULT 0;";

/* What the store knows about itself; jobs that were removed, and what stays of them; stored forms
 * of pictures that may be dropped. Shares of addresses and labels: the address of earlier jobs is
 * not known. */
static const char step_12[] =
    "CREATE TABLE meta (name TEXT PRIMARY KEY, value ANY NOT NULL) STRICT, WITHOUT ROWID;"
    "INSERT INTO meta VALUES ('identity', lower(hex(randomblob(16)))), ('log', 0);"
    "ALTER TABLE job ADD COLUMN removed_ms INTEGER NOT NULL DEFAULT 0;"
    "CREATE INDEX job_removed ON job(number) WHERE removed_ms > 0;"
    "CREATE INDEX job_by_end ON job(finished_ms, number)"
    " WHERE finished_ms > 0 AND removed_ms = 0;"
    "CREATE TABLE removed ("
    " id TEXT PRIMARY KEY,"
    " removed_ms INTEGER NOT NULL,"
    " stats TEXT"
    ") STRICT;"
    "CREATE INDEX removed_by_age ON removed(removed_ms);"
    "CREATE TABLE cached ("
    " artefact INTEGER PRIMARY KEY REFERENCES artefact(id) ON DELETE CASCADE,"
    " bytes INTEGER NOT NULL,"
    " used_ms INTEGER NOT NULL"
    ") STRICT;"
    "CREATE INDEX cached_by_use ON cached(used_ms, bytes);"
    "INSERT INTO cached SELECT id, length(data), 0 FROM artefact"
    " WHERE view < 0 OR format = 'png16' OR (format = 'pfm' AND layer = 'beauty')"
    " OR (format = 'png' AND layer IN ('cost', 'samples', 'depth', 'normal', 'albedo'));"
    "CREATE TABLE peer ("
    " id INTEGER PRIMARY KEY AUTOINCREMENT,"
    " priority INTEGER NOT NULL,"
    " address TEXT NOT NULL,"
    " jobs INTEGER NOT NULL DEFAULT 0 CHECK (jobs >= 0),"
    " served_us INTEGER NOT NULL DEFAULT 0,"
    " virtual_us INTEGER NOT NULL DEFAULT 0,"
    " waiting_since_ms INTEGER NOT NULL,"
    " UNIQUE (priority, address)"
    ") STRICT;"
    "CREATE INDEX peer_by_service ON peer(priority, served_us) WHERE jobs > 0;"
    "CREATE TABLE level ("
    " priority INTEGER PRIMARY KEY,"
    " virtual_us INTEGER NOT NULL DEFAULT 0"
    ") STRICT;"
    "CREATE TABLE lane ("
    " id INTEGER PRIMARY KEY AUTOINCREMENT,"
    " peer INTEGER NOT NULL REFERENCES peer(id),"
    " label TEXT NOT NULL,"
    " jobs INTEGER NOT NULL DEFAULT 0 CHECK (jobs >= 0),"
    " served_us INTEGER NOT NULL DEFAULT 0,"
    " balance_us INTEGER NOT NULL DEFAULT 0,"
    " UNIQUE (peer, label)"
    ") STRICT;"
    "CREATE INDEX lane_by_service ON lane(peer, served_us);"
    "ALTER TABLE job ADD COLUMN address TEXT NOT NULL DEFAULT '';"
    "ALTER TABLE job ADD COLUMN lane INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE batch ADD COLUMN lane INTEGER NOT NULL DEFAULT 0;"
    "INSERT INTO peer (priority, address, jobs, waiting_since_ms)"
    " SELECT priority, '', count(*), strftime('%s', 'now') * 1000 FROM job WHERE state < 2"
    " GROUP BY priority;"
    "INSERT INTO level (priority) SELECT DISTINCT priority FROM peer;"
    "INSERT INTO lane (peer, label, jobs) SELECT id, '', jobs FROM peer;"
    "UPDATE job SET lane = l.id FROM peer p JOIN lane l ON l.peer = p.id"
    " WHERE p.priority = job.priority AND job.state < 2;"
    "UPDATE batch SET lane = job.lane FROM job WHERE job.number = batch.job AND job.lane > 0;"
    "CREATE INDEX batch_open_of_lane ON batch(lane, job, id) WHERE state = 0;"
    "CREATE INDEX job_by_service ON job(lane, spent_us, number) WHERE state < 2;";

/* Lists of jobs by kind, name or label, so that they need not read all jobs. */
static const char step_13[] =
    "CREATE TABLE attribute ("
    " key TEXT NOT NULL,"
    " value TEXT NOT NULL,"
    " job INTEGER NOT NULL REFERENCES job(number) ON DELETE CASCADE,"
    " PRIMARY KEY (key, value, job)"
    ") STRICT, WITHOUT ROWID;"
    "CREATE INDEX attribute_by_job ON attribute(job);"
    "CREATE INDEX job_by_kind ON job(kind, number);"
    "INSERT OR IGNORE INTO attribute SELECT 'name', n.value, number FROM job,"
    " json_each(iif(json_valid(request), request, '{}')) n WHERE n.key = 'name' AND n.type = "
    "'text';"
    "INSERT OR IGNORE INTO attribute SELECT 'label:' || l.key, l.value, number FROM job,"
    " json_each(iif(json_valid(request), request, '{}'), '$.labels') l WHERE l.type = 'text';";

/* Large objects, which a row has, or none any more. */
static const char step_14[] =
    "CREATE TABLE large_object ("
    " id INTEGER PRIMARY KEY AUTOINCREMENT,"
    " bytes INTEGER NOT NULL,"
    " expires_ms INTEGER"
    ") STRICT;"
    "CREATE INDEX large_object_unused ON large_object(expires_ms) WHERE expires_ms IS NOT NULL;"
    "CREATE TABLE large_object_part ("
    " object INTEGER NOT NULL REFERENCES large_object(id),"
    " part INTEGER NOT NULL,"
    " data BLOB NOT NULL,"
    " PRIMARY KEY (object, part)"
    ") STRICT;"
    "ALTER TABLE artefact ADD COLUMN object INTEGER REFERENCES large_object(id);"
    "CREATE UNIQUE INDEX artefact_object ON artefact(object) WHERE object IS NOT NULL;"
    "ALTER TABLE pixels ADD COLUMN object INTEGER REFERENCES large_object(id);"
    "CREATE UNIQUE INDEX pixels_object ON pixels(object) WHERE object IS NOT NULL;"
    "CREATE TRIGGER artefact_removed AFTER DELETE ON artefact WHEN OLD.object IS NOT NULL BEGIN"
    " UPDATE large_object SET expires_ms = 0 WHERE id = OLD.object; END;"
    "CREATE TRIGGER artefact_replaced AFTER UPDATE OF object ON artefact"
    " WHEN OLD.object IS NOT NULL AND OLD.object IS NOT NEW.object BEGIN"
    " UPDATE large_object SET expires_ms = 0 WHERE id = OLD.object; END;"
    "CREATE TRIGGER pixels_removed AFTER DELETE ON pixels WHEN OLD.object IS NOT NULL BEGIN"
    " UPDATE large_object SET expires_ms = 0 WHERE id = OLD.object; END;";

static const char step_15[] = "ALTER TABLE job ADD COLUMN committed_us INTEGER NOT NULL DEFAULT 0;"
                              "ALTER TABLE job ADD COLUMN committed_ms INTEGER NOT NULL DEFAULT 0;";

/* Clients instead of addresses. A key belongs to the client of the job that it made, or to none
 * if that job was removed. The clients of removed jobs are not known. */
static const char step_16[] =
    "ALTER TABLE job RENAME COLUMN address TO client;"
    "ALTER TABLE peer RENAME COLUMN address TO client;"
    "UPDATE job SET client = 'address:' || client WHERE client <> '';"
    "UPDATE peer SET client = 'address:' || client WHERE client <> '';"
    "ALTER TABLE removed ADD COLUMN client TEXT NOT NULL DEFAULT '';"
    "CREATE TABLE client_key ("
    " client TEXT NOT NULL, key TEXT NOT NULL,"
    " body_sha256 BLOB NOT NULL CHECK (length(body_sha256) = 32),"
    " answer TEXT NOT NULL, created_ms INTEGER NOT NULL, PRIMARY KEY (client, key)"
    ") STRICT, WITHOUT ROWID;"
    "INSERT INTO client_key SELECT coalesce((SELECT client FROM job WHERE id ="
    " json_extract(iif(json_valid(answer), answer, '{}'), '$.id')), ''), key, body_sha256, answer,"
    " created_ms FROM idempotency;"
    "DROP TABLE idempotency;"
    "ALTER TABLE client_key RENAME TO idempotency;"
    "CREATE INDEX idempotency_by_age ON idempotency(created_ms);";

/* Labels have no share: a job and its batches belong to the peer itself. */
static const char step_17[] =
    "DROP INDEX batch_open_of_lane;"
    "DROP INDEX job_by_service;"
    "ALTER TABLE job RENAME COLUMN lane TO peer;"
    "ALTER TABLE batch RENAME COLUMN lane TO peer;"
    "UPDATE job SET peer = coalesce((SELECT l.peer FROM lane l WHERE l.id = job.peer), 0);"
    "UPDATE batch SET peer = coalesce((SELECT l.peer FROM lane l WHERE l.id = batch.peer), 0);"
    "DROP TABLE lane;"
    "ALTER TABLE peer ADD COLUMN balance_us INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE peer DROP COLUMN virtual_us;"
    "CREATE INDEX batch_open_of_peer ON batch(peer, job, id) WHERE state = 0;"
    "CREATE INDEX job_by_service ON job(peer, spent_us, number) WHERE state < 2;";

/* Durations that are measured instead of told by time stamps; and what is done of a job as a share
 * of its work, not of its pixels alone. */
static const char step_18[] =
    "ALTER TABLE job RENAME COLUMN committed_ms TO told_elapsed_us;"
    "ALTER TABLE job RENAME COLUMN committed_us TO told_us;"
    "ALTER TABLE job ADD COLUMN work INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE job ADD COLUMN cost_map BLOB;"
    "ALTER TABLE batch ADD COLUMN work INTEGER NOT NULL DEFAULT 0;"
    "UPDATE batch SET work = pixels * 1000000000 / (SELECT total_pixels FROM job"
    " WHERE number = batch.job) WHERE state = 2 AND kind <> 1;"
    "UPDATE job SET work = (SELECT coalesce(sum(work), 0) FROM batch WHERE job = job.number);"
    "ALTER TABLE job ADD COLUMN elapsed_us INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE job ADD COLUMN queue_us INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE job ADD COLUMN moment_boot INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE job ADD COLUMN moment_us INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE job ADD COLUMN moment_ms INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE batch ADD COLUMN commit_us INTEGER NOT NULL DEFAULT 0;"
    "UPDATE job SET queue_us = max(0, started_ms - created_ms) * 1000, moment_ms = updated_ms,"
    " told_elapsed_us = max(0, told_elapsed_us - created_ms) * 1000;"
    "UPDATE job SET elapsed_us = max(queue_us, told_elapsed_us,"
    " (updated_ms - created_ms) * 1000, (finished_ms - created_ms) * 1000);";

static const char *const steps[] = {step_1,  step_2,  step_3,  step_4,  step_5,  step_6,
                                    step_7,  step_8,  step_9,  step_10, step_11, step_12,
                                    step_13, step_14, step_15, step_16, step_17, step_18};
enum { STEP_COUNT = (int)(sizeof steps / sizeof steps[0]) };

/* Reads the schema's version by SQL, because the header of the file can be older than its log. */
static bool read_version(struct pen_sqlite_store *store, int64_t *version, struct pen_status *st)
{
    int64_t application = 0;
    if (!pen_sqlite_pragma(store, "PRAGMA application_id", &application, st) ||
        !pen_sqlite_pragma(store, "PRAGMA user_version", version, st))
        return false;
    if (application != SQL_APPLICATION_ID)
        return pen_fail(st, PEN_STORAGE,
                        "%s is a database of another program; give another path for the store",
                        store->path);
    if (*version > STEP_COUNT)
        return pen_fail(st, PEN_STORAGE,
                        "the store %s was written by a newer Penumbra (schema %d, this one knows "
                        "%d); use that version, or another store",
                        store->path, (int)*version, (int)STEP_COUNT);
    if (*version < 1)
        return pen_sqlite_damaged(store, st, "the store %s is damaged (its schema has version %d)",
                                  store->path, (int)*version);
    return true;
}

/* Takes all missing steps in one transaction: after a crash the store has the old schema or the
 * new. */
static bool take_steps(struct pen_sqlite_store *store, int version, struct pen_status *st)
{
    char mark[96];
    snprintf(mark, sizeof mark, "PRAGMA application_id = %d; PRAGMA user_version = %d",
             (int)SQL_APPLICATION_ID, (int)STEP_COUNT);
    bool ok = pen_sqlite_exec(store, "BEGIN IMMEDIATE", st);
    for (int i = version; ok && i < STEP_COUNT; i++)
        ok = pen_sqlite_exec(store, steps[i], st);
    ok = ok && pen_sqlite_exec(store, mark, st) && pen_sqlite_exec(store, "COMMIT", st);
    if (!ok && !sqlite3_get_autocommit(store->db))
        sqlite3_exec(store->db, "ROLLBACK", NULL, NULL, NULL);
    return ok;
}

bool pen_sqlite_make_schema(struct pen_sqlite_store *store, struct pen_status *st)
{
    return pen_sqlite_exec(store, "PRAGMA auto_vacuum = INCREMENTAL", st) &&
           take_steps(store, 0, st);
}

/* Upgrades a store, unless it is damaged or its tables are not those of its version. */
static bool upgrade(struct pen_sqlite_store *store, int version, struct pen_status *st)
{
    if (!pen_sqlite_check_file(store, st))
        return false;
    if (take_steps(store, version, st))
        return true;
    if (st->code != PEN_INTERNAL)
        return false;
    return pen_sqlite_damaged(store, st,
                              "the store %s is damaged (it is not of schema %d as it says)",
                              store->path, version);
}

bool pen_sqlite_migrate(struct pen_sqlite_store *store, struct pen_status *st)
{
    int64_t version = 0;
    return read_version(store, &version, st) &&
           (version == STEP_COUNT || upgrade(store, (int)version, st)) &&
           pen_sqlite_exec(store, "PRAGMA journal_mode = WAL", st);
}

/* Makes a trigger that refuses every change of state that is not in the table of transitions. */
static bool guard(struct pen_sqlite_store *store, const char *table, const struct pen_arrow *arrows,
                  int count, struct pen_status *st)
{
    struct pen_buf sql = {0};
    pen_buf_printf(&sql,
                   "CREATE TEMP TRIGGER %s_arrow BEFORE UPDATE OF state ON main.%s"
                   " WHEN NEW.state <> OLD.state AND NOT (0",
                   table, table);
    for (int i = 0; i < count; i++)
        pen_buf_printf(&sql, " OR (OLD.state = %d AND NEW.state = %d)", arrows[i].from,
                       arrows[i].to);
    pen_buf_printf(&sql, ") BEGIN SELECT RAISE(ABORT, 'illegal change of state of a %s'); END",
                   table);
    bool ok = sql.failed ? pen_fail(st, PEN_NO_MEMORY, "no memory for the store")
                         : pen_sqlite_exec(store, (const char *)sql.data, st);
    pen_buf_release(&sql);
    return ok;
}

bool pen_sqlite_guard_states(struct pen_sqlite_store *store, struct pen_status *st)
{
    int count;
    const struct pen_arrow *arrows = pen_job_arrows(&count);
    if (!guard(store, "job", arrows, count, st))
        return false;
    arrows = pen_batch_arrows(&count);
    return guard(store, "batch", arrows, count, st);
}
