/* SPDX-License-Identifier: MIT */
/* Addresses of clients, and how many waiting requests each of them has. No address may have more
 * than a given number, so that one client cannot take all the places. Addresses behind which there
 * can be many clients are exempt: the loopback interface, and a trusted proxy. */
#ifndef PEN_HTTP_INTERNAL_ADDRESSES_H
#define PEN_HTTP_INTERNAL_ADDRESSES_H

#include <stdbool.h>
#include <stdint.h>

struct sockaddr;

/* An IPv6 address, or an IPv4 address mapped into one; of IPv6 only the network (64 bits) counts,
 * since a host can take any address in it. */
struct pen_address_key {
    unsigned char bytes[16];
    bool exempt;
    bool is_proxy; /* it is the trusted proxy's */
};

enum { ADDRESSES_MAX = 1024 }; /* at least as many as there are places */

/* {0} is empty. */
struct addresses {
    int count;
    struct address_count {
        unsigned char bytes[16];
        int waiting;
    } item[ADDRESSES_MAX];
};

/* Reads a numeric address as IPv6. Returns false if the text is none. */
bool pen_http_address_parse(const char *text, unsigned char out[16]);

/* The key of a socket's peer. `trusted` is the address of a proxy, NULL: none; with
 * `count_loopback` loopback addresses are not exempt. */
struct pen_address_key pen_http_address_key(const struct sockaddr *peer,
                                            const unsigned char trusted[16], bool count_loopback);

/* The address of the client for whom a proxy sends a request: the last one that X-Forwarded-For
 * lists, since the proxy has added that one itself. Those before it may be anything. A port is
 * passed over. Returns false if it is no numeric address. */
bool pen_http_address_forwarded(const char *forwarded_for, struct pen_address_key *key);

/* Whether the addresses are the same, whatever else is known of them. */
bool pen_http_address_equal(const struct pen_address_key *a, const struct pen_address_key *b);

/* The address as text, an IPv4 address in dots; "" if it is not known. PEER_BYTES of text. */
enum { PEER_BYTES = 46 };
void pen_http_address_text(const struct pen_address_key *key, char text[PEER_BYTES]);

/* Counts one waiting request. Returns false if the address has `limit` already. */
bool pen_http_addresses_take(struct addresses *addresses, const struct pen_address_key *key,
                             int limit);
void pen_http_addresses_give(struct addresses *addresses, const struct pen_address_key *key);

#endif
