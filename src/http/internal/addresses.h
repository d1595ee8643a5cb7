/* SPDX-License-Identifier: MIT */
/* Addresses of clients as IPv6; an IPv4 address is mapped into one. Of an IPv6 address of a client
 * only the network (64 bits) is kept, since a host can take any address in it. */
#ifndef PEN_HTTP_INTERNAL_ADDRESSES_H
#define PEN_HTTP_INTERNAL_ADDRESSES_H

#include <stdbool.h>
#include <stddef.h>

struct sockaddr;

/* Reads a numeric address. Returns false if the text is none. */
bool pen_http_address_parse(const char *text, unsigned char out[16]);

/* The address of a socket's peer. Returns false for another family. */
bool pen_http_address_of(const struct sockaddr *peer, unsigned char out[16]);

bool pen_http_address_is_loopback(const unsigned char address[16]);

/* The address of the client for whom a proxy sends a request: the last one that X-Forwarded-For
 * lists, since the proxy has added that one itself. Those before it may be anything. A port is
 * passed over. Returns false if it is no numeric address. */
bool pen_http_address_forwarded(const char *forwarded_for, unsigned char out[16]);

/* Writes "address:IP"; "" for the address of all zeros, which stands for an unknown one. */
void pen_http_address_text(const unsigned char address[16], char *text, size_t bytes);

#endif
