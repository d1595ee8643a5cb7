/* SPDX-License-Identifier: MIT */
/* Random changes of scenes, for property tests. A member or element of a document is removed,
 * copied elsewhere, negated, or replaced by a value or key that is valid elsewhere in the
 * format. */
#ifndef TESTS_SUPPORT_MUTATE_H
#define TESTS_SUPPORT_MUTATE_H

#include <jansson.h>

#include "support/random.h"

/* Changes one place of the document, an object or array. */
void mutate_document(struct random *random, json_t *document);

#endif
