/* SPDX-License-Identifier: MIT */
/* The PostgreSQL server of tests/support/postgres.sh, if the test runs with it. */
#ifndef TESTS_CRASH_DATABASE_H
#define TESTS_CRASH_DATABASE_H

#include <sys/types.h>

/* Returns the URL of its database; NULL if there is no such server. */
const char *database_url(void);

/* Makes one in a hundred transactions that change a batch lose its connection during COMMIT. */
void database_break_commits(void);

enum database_fault {
    DATABASE_KILL,      /* the server is killed and started again */
    DATABASE_AWAY,      /* it is stopped, and started after 5 s */
    DATABASE_TERMINATE, /* it ends all connections */
    DATABASE_DEAF,      /* it ends the listening connections, several times: signals are lost */
    DATABASE_FAULTS
};
const char *database_fault_name(enum database_fault fault);

/* Causes a fault. The server works when the call returns. Reaps all children but `kept`, because
 * the new server must not find the killed server's process.
 * Fails: ends the process. */
void database_disturb(enum database_fault fault, pid_t kept);

#endif
