/* SPDX-License-Identifier: MIT */
/* Leases of workers that are no more. A supervisor tells a worker's successor whom it replaces;
 * but when everything was killed at once nobody is left to tell. Leases run out by themselves:
 * this only spares the wait. */
#ifndef PEN_CMD_DAEMON_ORPHANS_H
#define PEN_CMD_DAEMON_ORPHANS_H

#include "store/store.h"

/* Whether a worker of this name (see pen_worker_name) may still live: one of another host may;
 * one of this host does if its process is there and is a worker, and not the caller itself. */
bool pen_worker_may_live(const char *name);

/* Takes back the leases of all workers of this host that do not live. *opened is the number of
 * batches. Errors as pen_store_expire_leases. */
bool pen_orphans_sweep(struct pen_store *store, int *opened, struct pen_status *st);

/* Takes all workers of this host that do not live off the list. Errors as pen_store_workers. */
bool pen_orphans_forget(struct pen_store *store, struct pen_status *st);

#endif
