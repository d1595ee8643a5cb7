-- SPDX-License-Identifier: MIT
-- The tables of a store, for SQLite and PostgreSQL. Words in braces are replaced: {table options}, of tables that
-- are kept in the order of a key, stands for WITHOUT ROWID in SQLite. A build opens stores
-- of its own version alone. All integers are BIGINT; times are ms of the store's clock unless their names say _us.
-- Indexes have the columns of their conditions too, where a query is to be answered by the index alone.
-- There are no foreign keys: they take hidden locks on jobs. Numbers are never used again, so that a claim fits no
-- other batch. States: job 0 queued, 1 running, 2 succeeded, 3 failed, 4 cancelled; batch 0 open, 1 leased, 2 done,
-- 3 ended; object 0 loading, 1 used, 2 gone.

CREATE TABLE meta (
    name TEXT PRIMARY KEY,
    value TEXT NOT NULL
) {table options};

-- A document, stored once for each content. `used_ms` is written by each submit, so that a removal that looks
-- for documents without a job waits for it.
CREATE TABLE scene (
    number {identity},
    sha256 {bytes} NOT NULL UNIQUE,
    object BIGINT NOT NULL,
    used_ms BIGINT NOT NULL
);

CREATE TABLE job (
    number {identity},
    id TEXT NOT NULL UNIQUE,
    client TEXT NOT NULL,
    kind TEXT NOT NULL,
    priority BIGINT NOT NULL,
    state BIGINT NOT NULL,
    revision BIGINT NOT NULL,          -- grows with every change that a reader can see
    scene BIGINT NOT NULL,
    request TEXT NOT NULL,
    error TEXT,
    max_attempts BIGINT NOT NULL,
    charges BIGINT NOT NULL,           -- crashes charged since the last commit
    losses BIGINT NOT NULL,            -- workers lost, or results without space, since the last commit
    timeout_ms BIGINT NOT NULL,
    open_views BIGINT NOT NULL,
    done_pixels BIGINT NOT NULL,
    total_pixels BIGINT NOT NULL,
    work BIGINT NOT NULL,              -- share of the expected work that is done, in billionths: the sum of batch.work
    spent_us BIGINT NOT NULL,          -- how long workers have worked on it, by their monotonic clocks
    told_us BIGINT NOT NULL,           -- spent_us when `work` was last told,
    told_elapsed_us BIGINT NOT NULL,   -- and elapsed_us then
    estimate_ms BIGINT NOT NULL,       -- how long workers are expected to work on it; 0: not known
    cost_map {bytes},                  -- where its work lies, until it ends
    elapsed_us BIGINT NOT NULL,        -- since the submit, up to moment_*: its last change
    queue_us BIGINT NOT NULL,          -- elapsed_us at its first claim
    moment_boot BIGINT NOT NULL,
    moment_us BIGINT NOT NULL,
    moment_ms BIGINT NOT NULL,
    created_ms BIGINT NOT NULL,
    started_ms BIGINT NOT NULL,
    finished_ms BIGINT NOT NULL,
    updated_ms BIGINT NOT NULL,
    removed_ms BIGINT NOT NULL,        -- 0: not removed; its rows go in slices, its own row last
    results_bytes BIGINT NOT NULL      -- what its results are expected to take, until it ends
);
CREATE INDEX job_by_state ON job (state, number, removed_ms) WHERE removed_ms = 0;
CREATE INDEX job_by_kind ON job (kind, number) WHERE removed_ms = 0;
CREATE INDEX job_by_end ON job (finished_ms, number, removed_ms)
    WHERE finished_ms > 0 AND removed_ms = 0;
CREATE INDEX job_by_client ON job (client, state, results_bytes) WHERE state < 2;
CREATE INDEX job_by_scene ON job (scene);
CREATE INDEX job_removed ON job (number) WHERE removed_ms > 0;

-- What lists are filtered by: `name`, and `label:` with a label's key.
CREATE TABLE attribute (
    key TEXT NOT NULL,
    value TEXT NOT NULL,
    job BIGINT NOT NULL,
    PRIMARY KEY (key, value, job)
) {table options};
CREATE INDEX attribute_by_job ON attribute (job);

CREATE TABLE view (
    job BIGINT NOT NULL,
    view BIGINT NOT NULL,
    name TEXT NOT NULL,
    width BIGINT NOT NULL,
    height BIGINT NOT NULL,
    batches BIGINT NOT NULL,           -- render batches
    open_batches BIGINT NOT NULL,      -- those, and the assemble batch, that are not done
    PRIMARY KEY (job, view)
) {table options};

CREATE TABLE batch (
    number {identity},
    job BIGINT NOT NULL,
    view BIGINT NOT NULL,
    kind BIGINT NOT NULL,
    first_tile BIGINT NOT NULL,
    tile_count BIGINT NOT NULL,
    pixels BIGINT NOT NULL,
    told_pixels BIGINT NOT NULL,       -- those that the job's done_pixels has
    work BIGINT NOT NULL,              -- its part of job.work
    state BIGINT NOT NULL,
    priority BIGINT NOT NULL,          -- of its job, as is client: claims read batches alone
    client TEXT NOT NULL,
    turn BIGINT NOT NULL,
    not_before_ms BIGINT NOT NULL,     -- back-off after lost workers
    alone BIGINT NOT NULL,             -- quarantined: a worker was lost while it held it
    attempt BIGINT NOT NULL,
    worker TEXT,
    serial BIGINT NOT NULL,            -- of the claim, counted by the worker: a repeated call gets this batch
    claimed_ms BIGINT NOT NULL,
    lease_ms BIGINT NOT NULL,          -- the end of the lease
    spent_us BIGINT NOT NULL,          -- the part of job.spent_us under the present attempt
    revision BIGINT NOT NULL,          -- that its commit gave the job
    commit_us BIGINT NOT NULL,
    stats TEXT
);
CREATE INDEX batch_open ON batch (priority DESC, turn, number, job, state) WHERE state = 0;
CREATE INDEX batch_open_of_client ON batch (client, priority, turn) WHERE state = 0;
CREATE INDEX batch_leased ON batch (job, number) WHERE state = 1;
CREATE INDEX batch_by_job ON batch (job, view, first_tile);

-- A row to lock, so that two submits of one client do not take the same turns.
CREATE TABLE turn (
    client TEXT NOT NULL,
    priority BIGINT NOT NULL,
    turn BIGINT NOT NULL,
    PRIMARY KEY (client, priority)
) {table options};

-- A value of any length: pixels of a batch, a picture, layer or report, what a batch keeps, a scene document.
CREATE TABLE object (
    number {identity},
    job BIGINT NOT NULL,               -- 0: a scene's
    view BIGINT NOT NULL,
    batch BIGINT NOT NULL,             -- of pixels and of what a batch keeps; else 0
    attempt BIGINT NOT NULL,           -- under which a loading one is written
    layer TEXT NOT NULL,               -- '' for pixels, 'kept:NAME' for what is kept
    format TEXT NOT NULL,
    state BIGINT NOT NULL,
    bytes BIGINT NOT NULL,
    checksum BIGINT NOT NULL,
    touched_ms BIGINT NOT NULL         -- when a part was last written
);
CREATE INDEX object_used ON object (job, view, layer, format) WHERE state = 1;
CREATE INDEX object_of_batch ON object (batch) WHERE batch > 0;
CREATE INDEX object_loading ON object (number) WHERE state = 0;
CREATE INDEX object_gone ON object (number) WHERE state = 2;

CREATE TABLE part (
    object BIGINT NOT NULL,
    n BIGINT NOT NULL,
    data {bytes} NOT NULL,             -- at most 1 MiB
    PRIMARY KEY (object, n)
) {table options};

-- Idempotency keys outlive their jobs.
CREATE TABLE key (
    client TEXT NOT NULL,
    key TEXT NOT NULL,
    body_sha256 {bytes} NOT NULL,
    answer TEXT NOT NULL,
    created_ms BIGINT NOT NULL,
    PRIMARY KEY (client, key)
) {table options};
CREATE INDEX key_by_age ON key (created_ms);

-- Jobs that were removed, with the statistics that stay.
CREATE TABLE removed (
    id TEXT PRIMARY KEY,
    client TEXT NOT NULL,
    removed_ms BIGINT NOT NULL,
    stats TEXT,
    bytes BIGINT NOT NULL              -- of the statistics; 0: there are none
) {table options};
CREATE INDEX removed_by_age ON removed (removed_ms, bytes);
CREATE INDEX removed_empty ON removed (removed_ms) WHERE bytes = 0;

CREATE TABLE worker (
    id TEXT PRIMARY KEY,
    host TEXT NOT NULL,
    boot TEXT NOT NULL,                -- boot id, pid and start time tell whether its process still exists
    pid BIGINT NOT NULL,
    start BIGINT NOT NULL,
    supervisor BIGINT NOT NULL,        -- its pid, which reports the worker's end while it exists; 0: none
    supervisor_start BIGINT NOT NULL,
    threads BIGINT NOT NULL,
    rays_per_s BIGINT NOT NULL,        -- by its last batches; 0: not known
    lease_ms BIGINT NOT NULL,
    started_ms BIGINT NOT NULL,
    seen_ms BIGINT NOT NULL
) {table options};
