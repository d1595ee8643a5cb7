/* SPDX-License-Identifier: MIT */
/* Many connections to one server on the loopback interface, served by one thread. Each kind holds a
 * resource without using it. */
#ifndef TESTS_LOAD_CROWD_H
#define TESTS_LOAD_CROWD_H

#include <stdbool.h>
#include <stddef.h>

enum member_kind {
    MEMBER_IDLE,     /* has made one request and keeps its connection */
    MEMBER_TRICKLE,  /* sends a head, one byte at a time */
    MEMBER_HALF,     /* has sent the first half of a head */
    MEMBER_UPLOAD,   /* sends a body, one byte at a time */
    MEMBER_VANISHED, /* as idle; then it acknowledges no more bytes */
    MEMBER_POLL,     /* waits for a job */
    MEMBER_STREAM,   /* reads the events of a job; every second one vanishes */
    MEMBER_READER,   /* reads a picture through a window of 4 KiB, and reads slowly */
    MEMBER_KINDS
};
extern const char *const member_names[MEMBER_KINDS];

struct crowd_options {
    int port;
    const char *job, *picture; /* paths: of a job that does not end, of a large picture */
    int trickle_ms;            /* between two bytes */
};

struct crowd;

/* Makes a crowd. Ends the program if it cannot. */
struct crowd *crowd_new(const struct crowd_options *options);

/* Adds members. With `again`, a member whose connection the server closes connects again. */
void crowd_add(struct crowd *crowd, enum member_kind kind, int count, bool again);

/* Serves the crowd for `ms`. */
void crowd_run(struct crowd *crowd, int ms);

/* Returns the number of members of a kind whose connection is open and was not refused. For polls
 * and streams, an answer or its absence decides. */
int crowd_count(const struct crowd *crowd, enum member_kind kind);

/* Closes the connections of all members but the vanished ones. */
void crowd_leave(struct crowd *crowd);

/* Returns the number of vanished connections that this side still has open. */
int crowd_vanished(const struct crowd *crowd);
void crowd_free(struct crowd *crowd);

#endif
