/* SPDX-License-Identifier: MIT */
/* The statements of the SQLite driver. Parameters are bound in the order of their numbers. Numbers
 * of states and kinds are those of store.h: jobs 0 queued, 1 running, 2 succeeded, 3 failed, 4
 * cancelled; batches 0 open, 1 leased, 2 done, 3 ended; kinds 0 render, 1 assemble, 2 study. */
#include "store/sqlite/sqlite.h"

_Static_assert(PEN_JOB_QUEUED == 0 && PEN_JOB_RUNNING == 1 && PEN_JOB_SUCCEEDED == 2 &&
                   PEN_JOB_FAILED == 3 && PEN_JOB_CANCELLED == 4,
               "stores have these numbers");
_Static_assert(PEN_BATCH_OPEN == 0 && PEN_BATCH_LEASED == 1 && PEN_BATCH_DONE == 2 &&
                   PEN_BATCH_ENDED == 3,
               "stores have these numbers");
_Static_assert(PEN_BATCH_RENDER == 0 && PEN_BATCH_ASSEMBLE == 1 && PEN_BATCH_STUDY == 2,
               "stores have these numbers");

#define FIRST_COLUMN(name) #name
#define NEXT_COLUMN(name) ", " #name
#define JOB_COLUMNS PEN_SQLITE_JOB_COLUMNS(FIRST_COLUMN, NEXT_COLUMN)

#define FIRST_VALUE(name, value) #value
#define NEXT_VALUE(name, value) ", " #value
#define CLAIM_COLUMNS PEN_SQLITE_CLAIM_COLUMNS(FIRST_VALUE, NEXT_VALUE)
#define CLAIM_TABLES                                                                               \
    " FROM batch b JOIN job j ON j.number = b.job"                                                 \
    " JOIN view v ON v.job = b.job AND v.view = b.view JOIN scene s ON s.id = j.scene"

/* The leases of worker ?2, and those that ended before ?1. */
#define LOST "state = 1 AND (lease_until_ms < ?1 OR worker = ?2)"

#define OPEN "state = 0, worker = NULL, lease_until_ms = NULL"

/* A peer's time after its batch b has told its own: at most ten minutes above the others' least. */
#define SERVED(peer)                                                                               \
    "min(" peer ".served_us + ?3 - b.spent_us, coalesce((SELECT min(o.served_us) FROM peer o"      \
    " WHERE o.priority = " peer ".priority AND o.jobs > 0 AND o.id <> " peer ".id), " peer         \
    ".served_us + ?3) + 600000000)"
/* Where one that comes anew begins: at the virtual time, within the times of those that are there.
 */
#define ENTRY(virtual_us, least_us, most_us)                                                       \
    "coalesce(min(max(" virtual_us ", " least_us "), " most_us "), " virtual_us ")"
#define SERVED_P SERVED("p")
#define SERVED_PEER SERVED("peer")
#define PEER_ENTRY                                                                                 \
    ENTRY("(SELECT v.virtual_us FROM level v WHERE v.priority = peer.priority)",                   \
          "(SELECT min(o.served_us) FROM peer o WHERE o.priority = peer.priority AND o.jobs > 0)", \
          "(SELECT max(o.served_us) FROM peer o WHERE o.priority = peer.priority AND o.jobs > 0)")
/* The batch ?1, leased under the attempt ?2, that has spent less than ?3. */
#define SPENT_BATCH "b.id = ?1 AND b.attempt = ?2 AND b.state = 1 AND b.spent_us < ?3"

/* The jobs of a list: those before ?1 of a kind, state, name and label, each of which may be NULL.
 * There is a statement for each way to find them: all, and by each of the four, which then is not
 * NULL. */
#define HAS(key, value)                                                                            \
    "EXISTS (SELECT 1 FROM attribute a WHERE a.key = " key " AND a.value = " value                 \
    " AND a.job = number)"
#define JOBS_THAT_MATCH(tables)                                                                    \
    "SELECT " JOB_COLUMNS " FROM " tables " WHERE number < ?1 AND removed_ms = 0"                  \
    " AND (?2 IS NULL OR kind = ?2) AND (?7 IS NULL OR state = ?7)"                                \
    " AND (?4 IS NULL OR " HAS("'name'", "?4") ") AND (?5 IS NULL OR " HAS("'label:' || ?5",       \
                                                                           "?6") ")"
#define NEWEST_FIRST " ORDER BY number DESC LIMIT ?3"
#define WITH_ATTRIBUTE "attribute f CROSS JOIN job ON number = f.job"
#define NEWEST_ATTRIBUTE_FIRST " AND f.job < ?1 ORDER BY f.job DESC LIMIT ?3"

/* The lengths of values that may be large objects: of artefact a, and of pixels p. */
#define OBJECT_BYTES "(SELECT o.bytes FROM large_object o WHERE o.id = "
#define ARTEFACT_BYTES "coalesce(" OBJECT_BYTES "a.object), length(a.data))"
#define PIXELS_BYTES "coalesce(" OBJECT_BYTES "p.object), length(p.data))"

/* The pause of a job j ends by ?1, or so late that the clock was set back. */
#define GOES_ON "(j.paused_until_ms <= ?1 OR j.paused_until_ms > ?1 + 60000)"
_Static_assert(PEN_PAUSE_MAX_MS == 60000, "as GOES_ON has it");

/* A peer p has a batch to claim: open, of a job j whose pause ends by ?1. More may be asked of the
 * batch b in between. */
#define HAS_OPEN                                                                                   \
    "p.jobs > 0 AND EXISTS (SELECT 1 FROM batch b JOIN job j ON j.number = b.job"                  \
    " WHERE b.peer = p.id AND b.state = 0 AND " GOES_ON
#define END_OPEN ")"

/* Whether a peer has waited so long, at time `now`, that it comes before one of priority `top`: of
 * the highest one that waits, or of that of batch ?2. */
#define AGED(top, now)                                                                             \
    "priority < " top " AND priority + (" now " - waiting_since_ms) / 60000 > " top
#define AGED_ABOVE_ALL AGED("(SELECT max(priority) FROM waiting)", "?3")
#define OWN "(SELECT priority FROM batch WHERE id = ?2)"
#define AGED_ABOVE_OWN AGED(OWN, "?1")

/* The time since the submit of a job: since its last moment by the clock of the boot, if it was in
 * this boot, else by the store's clock. A clock that was set back takes nothing away. */
#define ELAPSED(now, boot, us)                                                                     \
    "elapsed_us + max(0, iif(moment_boot = " boot " AND " boot " <> 0, " us " - moment_us, (" now  \
    " - moment_ms) * 1000))"
#define ELAPSE(now, boot, us)                                                                      \
    "elapsed_us = " ELAPSED(now, boot, us) ", moment_ms = " now ", moment_boot = " boot            \
                                           ", moment_us = " us

/* Whether the document of job j goes with the ended jobs: no unfinished job names it. It counts
 * once, for the newest that names it. */
#define FREES_DOCUMENT                                                                             \
    "j.scene NOT IN (SELECT u.scene FROM job u WHERE u.state < 2)"                                 \
    " AND j.number = (SELECT max(o.number) FROM job o WHERE o.scene = j.scene)"

/* The removed jobs of which nothing stays (removed_purge in driver.h). */
#define PURGED                                                                                     \
    " WHERE rowid IN (SELECT rowid FROM removed"                                                   \
    " WHERE removed_ms < iif(stats IS NULL, ?1, ?2)"                                               \
    " AND NOT EXISTS (SELECT 1 FROM job WHERE job.id = removed.id)"                                \
    " ORDER BY removed_ms, rowid LIMIT ?3)"

#define CHANGE_STATS(sign, where)                                                                  \
    "UPDATE meta SET value = value " sign " (SELECT coalesce(sum(" PEN_SQLITE_STATS_BYTES "), 0)"  \
    " FROM removed" where ") WHERE name = 'stats_bytes'"

static const char *const sql_text[] = {
    [SQL_BEGIN_READ] = "BEGIN",
    [SQL_BEGIN_WRITE] = "BEGIN IMMEDIATE",
    [SQL_COMMIT] = "COMMIT",
    [SQL_ROLLBACK] = "ROLLBACK",
    [SQL_META_GET] = "SELECT value FROM meta WHERE name = ?",
    [SQL_META_PUT] = "INSERT INTO meta (name, value) VALUES (?1, ?2) ON CONFLICT (name)"
                     " DO UPDATE SET value = ?2",
    /* Any change will do that is written and synced; no caller's key is empty. */
    [SQL_PROBE] = "INSERT INTO idempotency (client, key, body_sha256, answer, created_ms)"
                  " VALUES ('', '', zeroblob(32), '', ?) ON CONFLICT (client, key)"
                  " DO UPDATE SET answer = '', created_ms = excluded.created_ms",
    [SQL_KEY_ADD] = "INSERT INTO idempotency (client, key, body_sha256, answer, created_ms)"
                    " VALUES (?, ?, ?, ?, ?) ON CONFLICT (client, key) DO NOTHING",
    [SQL_KEY_GET] = "SELECT body_sha256, answer FROM idempotency WHERE client = ? AND key = ?",
    [SQL_KEYS_REMOVE] = "DELETE FROM idempotency WHERE (client, key) IN"
                        " (SELECT client, key FROM idempotency WHERE created_ms < ? LIMIT ?)",
    [SQL_SCENE_FIND] = "SELECT id FROM scene WHERE sha256 = ?",
    [SQL_SCENE_ADD] = "INSERT INTO scene (sha256, document) VALUES (?, ?)"
                      " ON CONFLICT (sha256) DO NOTHING",
    [SQL_SCENE_OF_JOB] = "SELECT s.id, length(s.document) FROM job j JOIN scene s ON s.id = j.scene"
                         " WHERE j.id = ? AND j.removed_ms = 0",
    [SQL_SCENE_REMOVE_UNUSED] = "DELETE FROM scene WHERE id = ?1"
                                " AND NOT EXISTS (SELECT 1 FROM job WHERE scene = ?1)",
    [SQL_SCENES_REMOVE_UNUSED] = "DELETE FROM scene WHERE NOT EXISTS"
                                 " (SELECT 1 FROM job WHERE job.scene = scene.id)",
    [SQL_JOB_ADD] = "INSERT INTO job (id, kind, scene, priority, max_attempts, timeout_ms,"
                    " created_ms, updated_ms, total_pixels, open_views, request, client,"
                    " moment_ms, moment_boot, moment_us)"
                    " VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?7, ?8, ?9, ?10, ?11, ?7, ?12, ?13)"
                    " ON CONFLICT (id) DO NOTHING",
    [SQL_VIEW_ADD] = "INSERT INTO view (job, view, name, width, height, batches, open_batches)"
                     " VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?6)",
    [SQL_BATCH_ADD] =
        "INSERT INTO batch (job, view, kind, first_tile, tile_count, pixels, priority, peer)"
        " SELECT ?1, ?2, ?3, ?4, ?5, ?6, priority, peer FROM job WHERE number = ?1"
        " ON CONFLICT (job, view) WHERE kind = 1 DO NOTHING",

    [SQL_JOB_GET] = "SELECT " JOB_COLUMNS " FROM job WHERE id = ? AND removed_ms = 0",
    [SQL_JOB_LIST] = JOBS_THAT_MATCH("job") NEWEST_FIRST,
    [SQL_JOB_LIST_STATE] = JOBS_THAT_MATCH("job") " AND state = ?7" NEWEST_FIRST,
    [SQL_JOB_LIST_KIND] = JOBS_THAT_MATCH("job") " AND kind = ?2" NEWEST_FIRST,
    [SQL_JOB_LIST_NAME] = JOBS_THAT_MATCH(
        WITH_ATTRIBUTE) " AND f.key = 'name' AND f.value = ?4" NEWEST_ATTRIBUTE_FIRST,
    [SQL_JOB_LIST_LABEL] = JOBS_THAT_MATCH(
        WITH_ATTRIBUTE) " AND f.key = 'label:' || ?5 AND f.value = ?6" NEWEST_ATTRIBUTE_FIRST,
    [SQL_JOB_ATTRIBUTES] = "INSERT INTO attribute SELECT 'name', json_extract(?2, '$.name'), ?1"
                           " WHERE json_type(?2, '$.name') = 'text' UNION ALL"
                           " SELECT 'label:' || l.key, l.value, ?1 FROM json_each(?2, '$.labels') l"
                           " WHERE l.type = 'text'",
    [SQL_JOB_FIND] = "SELECT number, state, scene FROM job WHERE id = ? AND removed_ms = 0",
    [SQL_JOB_IS_OF] = "SELECT coalesce((SELECT client FROM job WHERE id = ?1),"
                      " (SELECT client FROM removed WHERE id = ?1)) = ?2",
    [SQL_JOB_COUNTS] = "SELECT state, count(*) - (SELECT count(*) FROM job r WHERE r.removed_ms > 0"
                       " AND r.state = job.state) FROM job GROUP BY state",
    [SQL_BATCH_COUNTS] = "SELECT (SELECT count(*) FROM batch WHERE state = 0),"
                         " (SELECT count(*) FROM batch WHERE state = 1)",
    [SQL_OLDEST_QUEUED] = "SELECT created_ms FROM job WHERE state = 0 ORDER BY number LIMIT 1",
    [SQL_JOB_START] =
        "UPDATE job SET state = 1, started_ms = ?2, updated_ms = ?2, revision = revision + 1,"
        " queue_us = " ELAPSED("?2", "?3", "?4") ", " ELAPSE("?2", "?3", "?4") " WHERE number = ?1"
                                                                               " AND state = 0",
    /* What is measured in a boot begins with the first claim there. */
    [SQL_JOB_ELAPSE] = "UPDATE job SET " ELAPSE("?2", "?3", "?4") " WHERE number = ?1"
                                                                  " AND moment_boot <> ?3",
    [SQL_JOB_PROGRESS] =
        "UPDATE job SET done_pixels = CASE WHEN ?7 THEN"
        " max(done_pixels, ?2 + (SELECT coalesce(sum(pixels), 0) FROM batch"
        " WHERE job = ?1 AND kind <> 1 AND state = 2))"
        " WHEN ?3 THEN done_pixels + ?2 ELSE min(?2, total_pixels) END, updated_ms = ?4,"
        " charges = CASE WHEN ?5 THEN 0 ELSE charges END,"
        " deaths = CASE WHEN ?5 THEN 0 ELSE deaths END,"
        " paused_until_ms = CASE WHEN ?5 THEN 0 ELSE paused_until_ms END,"
        " estimate_ms = CASE WHEN ?6 > 0 THEN ?6 ELSE estimate_ms END,"
        " work = CASE WHEN ?8 > 0 THEN work + ?9 - (SELECT work FROM batch WHERE id = ?8)"
        " ELSE work END,"
        " told_us = CASE WHEN ?8 > 0 AND (?5 OR ?6 > 0) THEN spent_us ELSE told_us END,"
        " told_elapsed_us = CASE WHEN ?8 > 0 AND (?5 OR ?6 > 0) THEN " ELAPSED(
            "?4", "?11",
            "?12") " ELSE told_elapsed_us END,"
                   " cost_map = CASE WHEN length(?10) > 0 THEN ?10 ELSE cost_map END, " ELAPSE(
                       "?4", "?11", "?12") ", revision = revision + 1 WHERE number = ?1",
    [SQL_BATCH_WORK] = "UPDATE batch SET work = ?2 WHERE id = ?1",
    [SQL_JOB_COST_MAP] = "SELECT cost_map FROM job WHERE id = ?",
    [SQL_JOB_VIEW_ENDED] = "UPDATE job SET open_views = open_views - 1 WHERE number = ?"
                           " RETURNING open_views",
    [SQL_JOB_SUCCEED] = "UPDATE job SET state = 2, finished_ms = ?2, cost_map = NULL"
                        " WHERE number = ?1 AND state = 1",
    [SQL_JOB_END] =
        "UPDATE job SET state = ?2, error = ?3, finished_ms = ?4, updated_ms = ?4,"
        " cost_map = NULL, " ELAPSE(
            "?4", "?5", "?6") ", revision = revision + 1 WHERE number = ?1 AND state IN (0, 1)",
    [SQL_JOB_END_BATCHES] = "UPDATE batch SET state = 3, worker = NULL, lease_until_ms = NULL,"
                            " quarantined = 0 WHERE job = ? AND state IN (0, 1)",
    [SQL_JOB_REMOVE] = "DELETE FROM job WHERE number = ?",
    [SQL_JOB_MARK_REMOVED] = "UPDATE job SET removed_ms = ?2 WHERE number = ?1",
    [SQL_REMOVED_NEXT] = "SELECT number, state, scene FROM job WHERE removed_ms > 0"
                         " ORDER BY number LIMIT 1",
    [SQL_ARTEFACTS_OF_JOB] = "SELECT id, length(data) FROM artefact WHERE job = ?"
                             " ORDER BY view DESC, layer DESC, format DESC LIMIT ?",
    [SQL_ARTEFACT_REMOVE] = "DELETE FROM artefact WHERE id = ?",
    [SQL_BATCHES_OF_JOB] = "SELECT b.id, coalesce(length(p.data), 0) FROM batch b"
                           " LEFT JOIN pixels p ON p.batch = b.id WHERE b.job = ?"
                           " ORDER BY b.view DESC, b.id DESC LIMIT ?",
    [SQL_BATCH_REMOVE] = "DELETE FROM batch WHERE id = ?",
    [SQL_FIRST_ENDED] = "SELECT id, finished_ms FROM job WHERE finished_ms > 0 AND finished_ms > ?"
                        " AND removed_ms = 0 ORDER BY finished_ms, number LIMIT 1",
    [SQL_COUNT_ENDED] = "SELECT count(*) FROM job WHERE finished_ms > 0 AND removed_ms = 0",
    [SQL_BYTES_OF_ENDED] =
        "SELECT iif(" FREES_DOCUMENT ", length(s.document), 0) + length(CAST(j.request AS BLOB))"
        " + (SELECT coalesce(sum(" ARTEFACT_BYTES "), 0) FROM artefact a WHERE a.job = j.number)"
        " + (SELECT coalesce(sum(coalesce(" PIXELS_BYTES ", 0)"
        " + coalesce(length(CAST(b.stats AS BLOB)), 0)), 0)"
        " FROM batch b LEFT JOIN pixels p ON p.batch = b.id WHERE b.job = j.number)"
        " FROM job j JOIN scene s ON s.id = j.scene WHERE j.finished_ms > 0 AND j.removed_ms = 0"
        " ORDER BY j.finished_ms, j.number",
    [SQL_BYTES_OF_STATS] = "SELECT length(CAST(stats AS BLOB)) FROM removed"
                           " WHERE stats IS NOT NULL ORDER BY removed_ms",
    [SQL_REMOVED_ADD] = "INSERT INTO removed (id, removed_ms, stats, client) VALUES (?1, ?2, ?3,"
                        " coalesce((SELECT client FROM job WHERE id = ?1), ''))",
    [SQL_REMOVED_GET] = "SELECT stats FROM removed WHERE id = ?",
    [SQL_REMOVED_DROP_STATS] = "UPDATE removed SET stats = NULL WHERE id = ?",
    [SQL_REMOVED_PURGE] = "DELETE FROM removed" PURGED,
    [SQL_STATS_COUNT] = "INSERT INTO meta (name, value) SELECT 'stats_bytes',"
                        " (SELECT coalesce(sum(" PEN_SQLITE_STATS_BYTES "), 0) FROM removed)"
                        " WHERE NOT EXISTS (SELECT 1 FROM meta WHERE name = 'stats_bytes')",
    [SQL_STATS_DROP] = "DELETE FROM meta WHERE name = 'stats_bytes'",
    [SQL_STATS_ENTER] = CHANGE_STATS("+", " WHERE id = ?1"),
    [SQL_STATS_LEAVE] = CHANGE_STATS("-", " WHERE id = ?1"),
    [SQL_STATS_PURGE] = CHANGE_STATS("-", PURGED),

    [SQL_ANY_OPEN] = "SELECT 1 FROM batch WHERE state = 0 LIMIT 1",
    /* Where ?4 allows it, peers first that have waited so long that they come before one of higher
     * priority; then by priority, then by the time served. A batch that a peer's worker holds
     * counts as a second until its worker has told its time. */
    [SQL_NEXT_PEER] =
        "WITH waiting AS MATERIALIZED (SELECT p.id, p.priority, p.served_us, p.waiting_since_ms,"
        " p.balance_us FROM peer p WHERE " HAS_OPEN " AND b.quarantined <= ?2" END_OPEN ")"
        " SELECT id, " AGED_ABOVE_ALL " AS aged, balance_us FROM waiting w"
        " ORDER BY ?4 AND aged DESC, priority DESC, served_us + 1000000 * (SELECT count(*)"
        " FROM batch h INDEXED BY batch_leased WHERE h.state = 1 AND h.peer = w.id), id LIMIT 1",
    [SQL_NEXT_OLDEST] = "SELECT b.job FROM batch b JOIN job j ON j.number = b.job"
                        " WHERE b.peer = ?3 AND b.state = 0 AND " GOES_ON
                        " AND b.quarantined <= ?2 ORDER BY b.job LIMIT 1",
    [SQL_NEXT_LEAST] = "SELECT j.number FROM job j WHERE j.peer = ?3 AND j.state < 2"
                       " AND " GOES_ON " AND EXISTS (SELECT 1 FROM batch b"
                       " WHERE b.peer = j.peer AND b.job = j.number AND b.state = 0"
                       " AND b.quarantined <= ?2) ORDER BY j.spent_us, j.number LIMIT 1",
    [SQL_FIRST_OPEN] = "SELECT " CLAIM_COLUMNS CLAIM_TABLES
                       " WHERE b.peer = (SELECT peer FROM job WHERE number = ?1) AND b.job = ?1"
                       " AND b.state = 0 AND b.quarantined <= ?2 ORDER BY b.id LIMIT 1",
    [SQL_OPEN_ABOVE] = "SELECT 1 FROM batch b JOIN job j ON j.number = b.job"
                       " WHERE b.state = 0 AND b.priority > " OWN " AND " GOES_ON " LIMIT 1",
    [SQL_OPEN_AGED] =
        "SELECT 1 FROM peer p WHERE " AGED_ABOVE_OWN " AND " HAS_OPEN END_OPEN " LIMIT 1",
    [SQL_OPEN_BESIDE] = "SELECT 1 FROM batch own JOIN batch b ON b.priority = own.priority"
                        " JOIN job j ON j.number = b.job WHERE own.id = ?2 AND b.state = 0"
                        " AND b.job <> own.job AND " GOES_ON " LIMIT 1",
    [SQL_OPEN_ELSEWHERE] = "SELECT 1 FROM batch own JOIN batch b ON b.state = 0"
                           " AND b.job <> own.job JOIN job j ON j.number = b.job"
                           " WHERE own.id = ?2 AND " GOES_ON " LIMIT 1",
    [SQL_HELD_BY] = "SELECT count(*), coalesce(sum(quarantined OR kind = 2), 0) FROM batch"
                    " WHERE state = 1 AND worker = ?",
    [SQL_FIRST_HELD] = "SELECT " CLAIM_COLUMNS CLAIM_TABLES
                       " WHERE b.state = 1 AND b.worker = ? ORDER BY b.id LIMIT 1",
    [SQL_BATCH_GET] = "SELECT b.job, b.view, b.kind, b.state, b.attempt, b.pixels,"
                      " b.lease_until_ms, b.spent_us, j.spent_us, j.deaths, j.started_ms,"
                      " b.work, j.work, j.total_pixels FROM batch b"
                      " JOIN job j ON j.number = b.job WHERE b.id = ?",
    [SQL_BATCH_LEASE] =
        "UPDATE batch SET state = 1, attempt = ?2, worker = ?3, lease_until_ms = ?4,"
        " spent_us = 0 WHERE id = ?1 AND state = 0",
    [SQL_BATCH_OPEN] = "UPDATE batch SET " OPEN " WHERE id = ? AND attempt = ? AND state = 1",
    [SQL_BATCH_REST] =
        "INSERT INTO batch (job, view, kind, first_tile, tile_count, pixels, priority, peer)"
        " SELECT job, view, kind, first_tile + ?3, tile_count - ?3, pixels - ?4, priority, peer"
        " FROM batch WHERE id = ?1 AND attempt = ?2 AND state = 1 AND kind = 0"
        " AND tile_count > ?3 AND pixels > ?4",
    [SQL_BATCH_CUT] = "UPDATE batch SET tile_count = ?3, pixels = ?4"
                      " WHERE id = ?1 AND attempt = ?2 AND state = 1",
    [SQL_VIEW_SPLIT] = "UPDATE view SET batches = batches + 1, open_batches = open_batches + 1"
                       " WHERE (job, view) = (SELECT job, view FROM batch WHERE id = ?)",
    [SQL_BATCH_DONE] =
        "UPDATE batch SET state = 2, worker = NULL, lease_until_ms = NULL, stats = ?3,"
        " done_ms = ?4, commit_us = ?5, quarantined = 0,"
        " revision = (SELECT revision FROM job WHERE number = batch.job)"
        " WHERE id = ?1 AND attempt = ?2 AND state = 1",
    [SQL_BATCH_EXTEND] = "UPDATE batch SET lease_until_ms = ?3"
                         " WHERE id = ?1 AND attempt = ?2 AND state = 1",
    [SQL_LEVEL_SPEND] =
        "UPDATE level SET virtual_us = level.virtual_us + max(0, " SERVED_P " - p.served_us)"
        " / max(1, (SELECT count(*) FROM peer o WHERE o.priority = p.priority AND o.jobs > 0))"
        " FROM peer p JOIN batch b ON b.peer = p.id"
        " WHERE level.priority = p.priority AND " SPENT_BATCH,
    [SQL_PEER_SPEND] =
        "UPDATE peer SET served_us = " SERVED_PEER ", waiting_since_ms = ?4,"
        " balance_us = max(-60000000, min(60000000, peer.balance_us + (?3 - b.spent_us)"
        " * CASE WHEN EXISTS (SELECT 1 FROM batch o WHERE o.peer = b.peer AND o.state = 0"
        " AND o.job < b.job) THEN -1 ELSE 1 END)) FROM batch b WHERE peer.id = b.peer"
        " AND " SPENT_BATCH,
    [SQL_JOB_SPEND] = "UPDATE job SET spent_us = job.spent_us + ?3 - b.spent_us FROM batch b"
                      " WHERE job.number = b.job AND " SPENT_BATCH,
    [SQL_BATCH_SPEND] = "UPDATE batch AS b SET spent_us = ?3 WHERE " SPENT_BATCH,

    [SQL_LEASES_OF_JOB] = "SELECT b.id, b.attempt, b.spent_us"
                          " + 1000 * max(0, min(w.lease_ms, ?2 - b.lease_until_ms + w.lease_ms))"
                          " FROM batch b INDEXED BY batch_leased JOIN worker w ON w.id = b.worker"
                          " WHERE b.state = 1 AND b.job = ?1 LIMIT ?3",

    [SQL_PEER_ADD] = "INSERT INTO peer (priority, client, waiting_since_ms) VALUES (?1, ?2, ?3)"
                     " ON CONFLICT (priority, client) DO NOTHING",
    [SQL_LEVEL_ADD] = "INSERT INTO level (priority) VALUES (?1) ON CONFLICT (priority) DO NOTHING",
    [SQL_PEER_ENTER] =
        "UPDATE peer SET jobs = jobs + 1, served_us = CASE WHEN jobs > 0 THEN served_us"
        " ELSE max(served_us, " PEER_ENTRY ") END,"
        " balance_us = CASE WHEN jobs > 0 THEN balance_us ELSE 0 END,"
        " waiting_since_ms = CASE WHEN EXISTS (SELECT 1 FROM batch b WHERE b.peer = peer.id"
        " AND b.state = 0) THEN waiting_since_ms ELSE ?3 END"
        " WHERE priority = ?1 AND client = ?2",
    [SQL_PEER_SERVED] =
        "UPDATE peer SET waiting_since_ms = ?2 WHERE id = (SELECT b.peer FROM batch b"
        " WHERE b.id = ?1)",
    [SQL_PEER_LEAVE] = "UPDATE peer SET jobs = jobs - 1 WHERE id = (SELECT j.peer FROM job j"
                       " WHERE j.number = ?1)",
    [SQL_PEERS_REMOVE] = "DELETE FROM peer WHERE jobs = 0 AND waiting_since_ms < ?1",
    [SQL_JOB_PEER] = "UPDATE job SET peer = (SELECT p.id FROM peer p WHERE p.priority = ?1"
                     " AND p.client = ?2) WHERE number = ?3",
    [SQL_QUEUE_LENGTHS] = "SELECT coalesce(sum(jobs), 0), coalesce(sum(CASE WHEN client = ?1"
                          " THEN jobs END), 0) FROM peer WHERE jobs > 0",
    [SQL_EXPECTED_COUNT] = "INSERT INTO meta (name, value) SELECT 'expected_bytes',"
                           " coalesce(sum(" PEN_SQLITE_EXPECTED_BYTES "), 0) FROM job j"
                           " WHERE j.state < 2 ON CONFLICT (name) DO UPDATE SET value ="
                           " excluded.value",
    [SQL_EXPECTED_DROP] = "DELETE FROM meta WHERE name = 'expected_bytes'",
    [SQL_EXPECTED_OF_JOB] = "SELECT " PEN_SQLITE_EXPECTED_BYTES " FROM job j WHERE j.number = ?1",
    [SQL_EXPECTED_ENTER] = "UPDATE meta SET value = value + (SELECT " PEN_SQLITE_EXPECTED_BYTES
                           " FROM job j WHERE j.number = ?1) WHERE name = 'expected_bytes'",
    [SQL_EXPECTED_LEAVE] = "UPDATE meta SET value = value - (SELECT " PEN_SQLITE_EXPECTED_BYTES
                           " FROM job j WHERE j.number = ?1) WHERE name = 'expected_bytes'",
    /* Peers take turns within their priority; the peer that was served least comes first. */
    [SQL_QUEUE] = "WITH of_peer AS (SELECT j.id, j.peer, row_number() OVER (PARTITION BY j.peer"
                  " ORDER BY j.number) AS turn FROM job j WHERE j.state = 0)"
                  " SELECT o.id FROM of_peer o JOIN peer p ON p.id = o.peer"
                  " ORDER BY p.priority DESC, o.turn, p.served_us, p.id",
    /* The batches in hand: what is left of each, by its share of what is left of its job, which its
     * estimate or else its rate tells; but no more than a turn (claims.c). */
    [SQL_QUEUE_FACTS] =
        "WITH hand AS MATERIALIZED (SELECT job, min(60000000, left_us,"
        " CAST(1.0 * left_us * pixels / max(1, rest) AS INTEGER)) AS us FROM"
        " (SELECT b.job, b.pixels, j.total_pixels - j.done_pixels AS rest,"
        " CASE WHEN j.estimate_ms > 0 THEN max(0, j.estimate_ms * 1000 - j.spent_us)"
        " WHEN j.done_pixels > 0 THEN CAST(1.0 * j.spent_us * (j.total_pixels - j.done_pixels)"
        " / j.done_pixels AS INTEGER) END AS left_us FROM batch b JOIN job j ON j.number = b.job"
        " WHERE b.state = 1 AND b.kind <> 1))"
        "SELECT (SELECT count(*) FROM job WHERE state = 1)"
        " - (SELECT count(DISTINCT job) FROM hand WHERE us IS NOT NULL),"
        " (SELECT count(*) FROM worker w WHERE w.seen_ms + w.lease_ms > ?1 OR EXISTS (SELECT 1"
        " FROM batch b WHERE b.state = 1 AND b.worker = w.id AND b.lease_until_ms > ?1)),"
        " (SELECT CAST(coalesce(avg(spent_us), 0) AS INTEGER) FROM (SELECT spent_us FROM job"
        " WHERE finished_ms > 0 AND removed_ms = 0 AND spent_us > 0"
        " ORDER BY finished_ms DESC LIMIT 50)),"
        " (SELECT coalesce(sum(us), 0) FROM hand)",
    [SQL_NEXT_SCENE] = "SELECT s.id, length(s.document), 0, NULL, (SELECT min(j.id) FROM job j"
                       " WHERE j.scene = s.id AND j.removed_ms = 0), ''"
                       " FROM scene s WHERE s.id > ? ORDER BY s.id LIMIT 1",
    [SQL_NEXT_PIXELS] = "SELECT p.batch, " PIXELS_BYTES ", b.pixels, NULL, j.id, '' FROM pixels p"
                        " JOIN batch b ON b.id = p.batch JOIN job j ON j.number = b.job"
                        " WHERE p.batch > ? ORDER BY p.batch LIMIT 1",
    [SQL_NEXT_ARTEFACT] =
        "SELECT a.id, " ARTEFACT_BYTES ", 0, a.checksum, j.id, a.layer || ' ' || a.format"
        " FROM artefact a JOIN job j ON j.number = a.job WHERE a.id > ? ORDER BY a.id LIMIT 1",
    [SQL_VIEW_BATCH_DONE] = "UPDATE view SET open_batches = open_batches - 1"
                            " WHERE job = ? AND view = ? RETURNING batches, open_batches",

    [SQL_TIMES_AHEAD] =
        "SELECT 1 WHERE EXISTS (SELECT 1 FROM peer INDEXED BY peer_by_service WHERE jobs > 0"
        " AND waiting_since_ms > ?1) OR EXISTS (SELECT 1 FROM worker WHERE seen_ms > ?1)"
        " OR EXISTS (SELECT 1 FROM batch b INDEXED BY batch_leased JOIN worker w ON w.id = b.worker"
        " WHERE b.state = 1 AND b.lease_until_ms > ?1 + w.lease_ms)",
    [SQL_PEERS_MEND] = "UPDATE peer INDEXED BY peer_by_service SET waiting_since_ms = ?1"
                       " WHERE jobs > 0 AND waiting_since_ms > ?1",
    [SQL_WORKERS_MEND] = "UPDATE worker SET seen_ms = ?1 WHERE seen_ms > ?1",
    [SQL_LEASES_MEND] = "UPDATE batch SET lease_until_ms = ?1 + w.lease_ms FROM worker w"
                        " WHERE batch.state = 1 AND w.id = batch.worker"
                        " AND batch.lease_until_ms > ?1 + w.lease_ms",

    [SQL_ANY_LOST] = "SELECT 1 FROM batch WHERE " LOST " LIMIT 1",
    [SQL_LOST_JOBS] = "SELECT number, deaths, charges, max_attempts FROM job WHERE number > ?3"
                      " AND number IN (SELECT job FROM batch WHERE " LOST ")"
                      " ORDER BY number LIMIT ?4",
    [SQL_OPEN_LOST] = "UPDATE batch SET " OPEN ", quarantined = max(quarantined, ?3) WHERE " LOST,
    [SQL_JOB_SET_DEATHS] = "UPDATE job SET deaths = ?2, paused_until_ms = ?3 WHERE number = ?1",
    [SQL_JOB_SET_CHARGES] = "UPDATE job SET charges = ?2, updated_ms = ?3,"
                            " revision = revision + 1 WHERE number = ?1",

    [SQL_PIXELS_ADD] = "INSERT INTO pixels (batch, data, object) VALUES (?, ?, ?)",
    [SQL_PIXELS_PAGE] = "SELECT b.id, b.pixels, b.first_tile, b.tile_count, " PIXELS_BYTES
                        " FROM batch b JOIN pixels p ON p.batch = b.id"
                        " WHERE b.job = ? AND b.view = ? AND b.kind = 0 AND b.id > ?"
                        " ORDER BY b.id LIMIT ?",
    [SQL_ARTEFACT_PUT] =
        "INSERT INTO artefact (job, view, layer, format, data, checksum,"
        " object) VALUES (?, ?, ?, ?, ?, ?, ?) ON CONFLICT (job, view, layer, format)"
        " DO UPDATE SET data = excluded.data, checksum = excluded.checksum,"
        " object = excluded.object RETURNING id",
    [SQL_ARTEFACT_FIND] = "SELECT a.id, a.checksum, " ARTEFACT_BYTES ", c.used_ms FROM artefact a"
                          " LEFT JOIN cached c ON c.artefact = a.id WHERE job = ? AND view = ? AND "
                          "layer = ? AND format = ?",
    [SQL_ARTEFACTS_DROP] = "DELETE FROM artefact WHERE job = ? AND view = ? AND layer = ?",
    [SQL_JOB_ARTEFACTS_DROP] = "DELETE FROM artefact WHERE job = ? AND layer = ?",
    [SQL_PIXELS_PART] = "SELECT p.data FROM pixels r JOIN large_object_part p"
                        " ON p.object = r.object WHERE r.batch = ? AND p.part = ?",
    [SQL_ARTEFACT_PART] = "SELECT p.data FROM artefact r JOIN large_object_part p"
                          " ON p.object = r.object WHERE r.id = ? AND p.part = ?",
    [SQL_OBJECT_ADD] = "INSERT INTO large_object (bytes, expires_ms) VALUES (?, 1)",
    [SQL_OBJECT_TOUCH] = "UPDATE large_object SET expires_ms = ?2 WHERE id = ?1 AND expires_ms > 0",
    [SQL_OBJECT_PART_ADD] = "INSERT INTO large_object_part (object, part, data) VALUES (?, ?, ?)",
    [SQL_OBJECT_USE] = "UPDATE large_object SET expires_ms = NULL WHERE id = ? AND expires_ms > 0",
    [SQL_OBJECT_RELEASE] = "UPDATE large_object SET expires_ms = 0 WHERE id = ?",
    [SQL_OBJECT_UNUSED] = "SELECT id FROM large_object WHERE expires_ms IS NOT NULL"
                          " AND (expires_ms < ? OR expires_ms > ?)"
                          " ORDER BY expires_ms DESC, id DESC LIMIT 1",
    [SQL_OBJECT_RELEASED_BYTES] =
        "SELECT coalesce(sum(min(o.bytes, ?1 * (SELECT count(*) FROM large_object_part p"
        " WHERE p.object = o.id))), 0) FROM large_object o WHERE o.expires_ms = 0",
    [SQL_OBJECT_PARTS_REMOVE] = "DELETE FROM large_object_part WHERE rowid IN (SELECT rowid"
                                " FROM large_object_part WHERE object = ?"
                                " ORDER BY part DESC LIMIT ?)",
    [SQL_OBJECT_REMOVE] = "DELETE FROM large_object WHERE id = ?",
    [SQL_CACHED_PUT] = "INSERT INTO cached (artefact, bytes, used_ms) VALUES (?1, ?2, ?3)"
                       " ON CONFLICT (artefact) DO UPDATE SET bytes = ?2, used_ms = ?3",
    [SQL_CACHED_TOUCH] = "UPDATE cached SET used_ms = ?2 WHERE artefact = ?1",
    [SQL_CACHED_BYTES] = "SELECT coalesce(sum(bytes), 0) FROM cached",
    [SQL_CACHED_FIRST] = "SELECT artefact, bytes FROM cached ORDER BY used_ms LIMIT 1",
    [SQL_STATS_PAGE] = "SELECT id, view, kind, commit_us, stats FROM batch"
                       " WHERE job = ? AND id > ? AND state = 2 AND stats IS NOT NULL"
                       " ORDER BY id LIMIT ?",
    [SQL_BATCH_PAGE] = "SELECT id, attempt, kind, state, view, first_tile, tile_count, pixels,"
                       " worker, quarantined FROM batch WHERE job = ? AND id > ?"
                       " ORDER BY id LIMIT ?",
    [SQL_COMMIT_PAGE] = "SELECT revision, view, first_tile, tile_count FROM batch"
                        " WHERE job = ? AND revision > ? AND kind = 0 ORDER BY revision LIMIT ?",

    [SQL_WORKER_PUT] = "INSERT INTO worker (id, host, pid, threads, lease_ms, started_ms, seen_ms,"
                       " lock_file) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?6, ?7) ON CONFLICT (id)"
                       " DO UPDATE SET threads = ?4, lease_ms = ?5, seen_ms = ?6, lock_file = ?7",
    [SQL_WORKER_LOCK_FILE] = "SELECT lock_file FROM worker WHERE id = ? AND lock_file IS NOT NULL",
    [SQL_WORKER_REMOVE] = "DELETE FROM worker WHERE id = ?",
    [SQL_WORKERS_REMOVE] = "DELETE FROM worker WHERE seen_ms < ?",
    [SQL_WORKER_LIST] = "SELECT w.id, w.host, w.pid, w.threads, w.started_ms, max(w.seen_ms,"
                        " coalesce(b.lease_until_ms - w.lease_ms, 0)), j.id, j.kind, v.name, b.id,"
                        " b.attempt, b.kind, b.pixels FROM worker w"
                        " LEFT JOIN batch b ON b.state = 1 AND b.worker = w.id"
                        " LEFT JOIN job j ON j.number = b.job"
                        " LEFT JOIN view v ON v.job = b.job AND v.view = b.view"
                        " ORDER BY w.started_ms, w.id, b.id",
    [SQL_WORKER_IDS] = "SELECT id FROM worker WHERE id > ?1 UNION"
                       " SELECT worker FROM batch WHERE state = 1 AND worker > ?1"
                       " ORDER BY 1 LIMIT ?2",

    [SQL_FREE_PAGES] = "PRAGMA freelist_count",
    [SQL_PAGES] = "PRAGMA page_count",
    [SQL_VACUUM] = "PRAGMA incremental_vacuum(1)",
};
_Static_assert(sizeof sql_text / sizeof sql_text[0] == SQL_COUNT, "a text for each statement");

const char *pen_sqlite_sql_text(enum pen_sqlite_sql sql)
{
    return sql_text[sql];
}
