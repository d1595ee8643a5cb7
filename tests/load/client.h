/* SPDX-License-Identifier: MIT */
/* A connection to a server on the loopback interface, and raw bytes on it. */
#ifndef TESTS_LOAD_CLIENT_H
#define TESTS_LOAD_CLIENT_H

#include <stdbool.h>
#include <stddef.h>

/* Connects a socket, with this receive buffer unless it is 0. Ends the program if it cannot. */
int load_connect(int port, int receive_bytes);

/* Connects a socket; returns -1 if the server accepts no connection. */
int load_try(int port, int receive_bytes);

/* Sends all bytes. Returns false if the connection has ended. */
bool load_send(int fd, const void *bytes, size_t count);

enum load_end {
    LOAD_OPEN,
    LOAD_CLOSED, /* by the server */
    LOAD_RESET
};

/* Reads until the connection ends, no byte comes for `quiet_ms`, or `until` (NULL: none) has come.
 * The first bytes are kept as a string in `text`, as many as fit. */
enum load_end load_read(int fd, int quiet_ms, const char *until, char *text, size_t room);

/* Returns the first final status in an answer, not 1xx; 0 if there is none. Sets *rest to the text
 * after its status line. */
int load_status(const char *text, const char **rest);

/* Seconds since an arbitrary start. */
double load_seconds(void);

#endif
