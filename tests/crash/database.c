/* SPDX-License-Identifier: MIT */
#include "database.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>

#include "daemon.h"

enum { START_TRIES = 60, AWAY_MS = 5000, DEAF_TIMES = 5 };

const char *database_url(void)
{
    return getenv("PENUMBRA_TEST_POSTGRES");
}

const char *database_fault_name(enum database_fault fault)
{
    static const char *const names[DATABASE_FAULTS] = {"servers killed", "servers away for 5 s",
                                                       "ends of all connections",
                                                       "ends of those that listen"};
    return names[fault];
}

static void must_run(const char *command)
{
    if (system(command) == 0)
        return;
    printf("not ok: %s\n", command);
    exit(1);
}

void database_break_commits(void)
{
    must_run("psql -qXtd test -c 'CREATE FUNCTION lose() RETURNS trigger LANGUAGE plpgsql AS "
             "$$ BEGIN IF random() < 0.01 THEN PERFORM pg_terminate_backend(pg_backend_pid()); "
             "END IF; RETURN NULL; END $$; CREATE CONSTRAINT TRIGGER lose AFTER UPDATE ON batch "
             "DEFERRABLE INITIALLY DEFERRED FOR EACH ROW EXECUTE FUNCTION lose()'");
}

/* Other processes of a killed server may still end. */
static void start(pid_t kept)
{
    for (int i = 0; i < START_TRIES; i++) {
        daemon_reap_others(kept);
        if (system("cd / && $PENUMBRA_TEST_PG_CTL start >/dev/null 2>&1") == 0)
            return;
        pause_ms(250);
    }
    must_run("cd / && $PENUMBRA_TEST_PG_CTL start");
}

static void end_connections(const char *condition)
{
    char command[400];
    snprintf(command, sizeof command,
             "psql -qXtd test -c \"SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE "
             "application_name = 'penumbrad' AND %s\" >/dev/null",
             condition);
    must_run(command);
}

void database_disturb(enum database_fault fault, pid_t kept)
{
    switch (fault) {
    case DATABASE_KILL:
        must_run("kill -KILL $(head -1 $PENUMBRA_TEST_POSTGRES_DATA/postmaster.pid)");
        start(kept);
        break;
    case DATABASE_AWAY:
        must_run("cd / && $PENUMBRA_TEST_PG_CTL -m fast stop >/dev/null");
        pause_ms(AWAY_MS);
        start(kept);
        break;
    case DATABASE_TERMINATE:
        end_connections("true");
        break;
    case DATABASE_DEAF:
        for (int i = 0; i < DEAF_TIMES; i++) {
            end_connections("(query LIKE '%LISTEN%' OR query LIKE '%NOTIFY%')");
            pause_ms(100);
        }
        break;
    case DATABASE_FAULTS:
        break;
    }
}
