/* SPDX-License-Identifier: MIT */
/* Addresses of clients as IPv6; an IPv4 address is mapped into IPv6. A client with IPv6 is known by
 * its network (64 bits), since a host can take any address in it. */
#ifndef PEN_HTTP_INTERNAL_ADDRESSES_H
#define PEN_HTTP_INTERNAL_ADDRESSES_H

#include <stdbool.h>
#include <stddef.h>

struct sockaddr;

/* Reads a numeric address. Returns false if the text is not one. */
bool pen_http_address_parse(const char *text, unsigned char out[16]);

/* The address of a socket's peer. Returns false for another family. */
bool pen_http_address_of(const struct sockaddr *peer, unsigned char out[16]);

bool pen_http_address_is_loopback(const unsigned char address[16]);

/* Reads the client's address from a proxy's X-Forwarded-For. It is the last one in the list, which
 * the proxy has added itself; a client can forge the others. A port is ignored. Returns false if
 * the address is not numeric. */
bool pen_http_address_forwarded(const char *forwarded_for, unsigned char out[16]);

/* Writes "address:IP". An address of zeros is unknown: its text is "". */
void pen_http_address_text(const unsigned char address[16], char *text, size_t bytes);

#endif
