/* SPDX-License-Identifier: MIT */
/* Clients that send a body of 20 MB to /v1/jobs before they read, as most libraries do, and give up
 * if they cannot. The server refuses the body early, by its length or after 16 MiB of its chunks.
 * The 413 must still arrive.
 *
 *     early PORT [COUNT]    prints how many of COUNT (20) clients got the 413; exit 1 if any did
 * not
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "load/cases.h"
#include "load/client.h"

enum { BODY_BYTES = 20 << 20, ANSWER_MS = 5000 };

static bool refused(int port, bool chunked)
{
    static char chunk[10 + 65536 + 2] = "00010000\r\n"; /* its size line, zeros, its end */
    const char *piece = chunked ? chunk : chunk + 10;
    size_t piece_bytes = chunked ? sizeof chunk : 65536;
    char head[200], answer[1000];
    memcpy(chunk + sizeof chunk - 2, "\r\n", 2);
    int fd = load_connect(port, 0);
    snprintf(head, sizeof head, "POST /v1/jobs HTTP/1.1\r\n" LOAD_HOST "%s: %s\r\n\r\n",
             chunked ? "Transfer-Encoding" : "Content-Length", chunked ? "chunked" : "20971520");
    bool sent = load_send(fd, head, strlen(head));
    for (int i = 0; sent && i < BODY_BYTES / 65536; i++)
        sent = load_send(fd, piece, piece_bytes);
    if (sent)
        load_read(fd, ANSWER_MS, "\r\n\r\n", answer, sizeof answer);
    close(fd);
    return sent && load_status(answer, NULL) == 413;
}

int main(int argc, char **argv)
{
    if (argc < 2 || argc > 3) {
        fprintf(stderr, "usage: early PORT [COUNT]\n");
        return 2;
    }
    int count = argc > 2 ? atoi(argv[2]) : 20, missed = 0;
    for (int chunked = 0; chunked < 2; chunked++) {
        double begun = load_seconds();
        int got = 0;
        for (int i = 0; i < count; i++)
            got += refused(atoi(argv[1]), chunked);
        printf("%s: %d of %d clients got the 413, %.0f ms each\n",
               chunked ? "chunked" : "with a length", got, count,
               (load_seconds() - begun) * 1000 / count);
        missed += count - got;
    }
    return missed > 0;
}
