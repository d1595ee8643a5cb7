/* SPDX-License-Identifier: MIT */
/* The choice of `auto`: the expected time of a ray's query with each of enum pen_auto_choice, by a
 * cost model of the finished tree and of the primitives.
 *
 * The unit is the time of one test of a block of four triangles, as for the builders (pen_kinds,
 * pen_node_cost). Work that costs the same with each choice, such as shading, is left out. A ray
 * enters a box with the probability of the surface-area heuristic (cost.c). The model is
 *
 *   none     RAY + I + L         I: the infinite primitives, L: the blocks of all others
 *   tree     RAY + TREE + I + F  F: the nodes and leaves that the ray enters
 *   packets  (1 - q) (RAY_IN_PACKET + J + SHARE F) + q (tree + GIVEN_UP)
 *            J: the infinite primitives, each tested against all rays of a packet
 *            q: the probability that a packet meets a finite primitive without a test in lanes,
 *               so that its rays are traced one by one in the end
 *
 * A packet tests every infinite primitive. A primitive without a test in lanes is left to the
 * scalar test, ray by ray, which costs more than in a list. So about four infinite cylinders are
 * enough to make packets slower.
 *
 * Neither soft lights nor coincident surfaces affect the choice. Disk packets of soft lights work
 * with each choice. Coincident surfaces, whose pixels are traced ray by ray after their packet, add
 * the same to each. `cbr`, `manual` and `median` are no choices: in no measurement were they more
 * than 5 % faster than the best of these three.
 *
 * The constants were measured with AVX2 and are the same for every instruction set, so that a scene
 * has the same structure on every machine. `make bench-choices` measures the choices again, beside
 * the times that the model expects. All sums are in binary64, in a fixed order. */
#include <math.h>

#include "accel/internal/tree_layout.h"

static const double ray = 2.3;  /* begin and end of a ray's query */
static const double tree = 0.7; /* preparation of a ray for boxes */
static const double ray_in_packet =
    0.9;                            /* a ray's share of beginning and ending a packet's query */
static const double share = 0.5;    /* a ray's share of the nodes and of the tests in a packet */
static const double given_up = 1.2; /* cost of a packet before its rays are traced one by one */
static const double plane_in_packet = 0.4; /* one plane */
static const double fallback = 1.2;        /* the scalar test of a ray of a packet */
static const double reach = 3; /* primitives that a packet meets, per primitive that a ray meets */

const char *pen_auto_choice_name(enum pen_auto_choice choice)
{
    static const char *const names[PEN_AUTO_COUNT] = {"none", "tree", "packets"};
    return names[choice];
}

/* All finite primitives in one list. */
static double cost_of_list(const struct pen_tree_layout *layout)
{
    uint32_t lanes[PEN_COST_CLASS_COUNT] = {0};
    for (uint32_t i = 0; i < layout->count; i++)
        lanes[layout->ref[i].cost_class] += layout->ref[i].lanes;
    return (double)pen_leaf_cost(lanes);
}

/* The cost of the infinite primitives, for a ray alone and for one in a packet. */
static void cost_of_infinite(const struct pen_tree_layout *layout, double *alone, double *packet)
{
    const double plane = (double)pen_kinds[PEN_PRIM_PLANE].cost;
    uint32_t planes = 0;
    *alone = *packet = 0;
    for (uint32_t i = layout->count; i < layout->count + layout->infinite; i++) {
        const struct pen_ref *ref = &layout->ref[i];
        if (ref->kind == PEN_BLOCK_PLANES)
            planes++;
        else
            *alone += (double)pen_kinds[pen_prim_kind(layout->prims, ref->prim)].cost;
    }
    *packet = fallback * *alone + plane_in_packet * planes;
    *alone += plane * ceil((double)planes / PEN_LANES);
}

/* The expected work of a ray in a tree. */
struct expected {
    double cost;          /* of nodes and leaves */
    double without_lanes; /* number of primitives without a test in lanes */
};

static void add_leaf(const struct pen_tree_layout *layout, const struct pen_leaf *leaf,
                     double probability, struct expected *sum)
{
    uint32_t lanes[PEN_COST_CLASS_COUNT] = {0}, without_lanes = 0;
    for (uint32_t i = leaf->begin; i < leaf->begin + leaf->count; i++) {
        lanes[layout->ref[i].cost_class] += layout->ref[i].lanes;
        without_lanes += layout->ref[i].kind == PEN_BLOCK_GENERIC;
    }
    sum->cost += probability * (double)pen_leaf_cost(lanes);
    sum->without_lanes += probability * without_lanes;
}

/* The nodes of a tree, of which a part has at least NODES_LEAST and at most a PARTS-th. */
enum { PARTS = 64, NODES_LEAST = 1 << 12 };

struct expecting {
    const struct pen_tree_layout *layout;
    double root;   /* half the area of the box around all */
    uint32_t each; /* nodes of a part */
    struct expected part[PARTS];
};

static void expect_part(void *user, uint32_t part)
{
    struct expecting *e = user;
    const struct pen_tree_layout *layout = e->layout;
    const struct pen_leaf *leaves = layout->leaves.data;
    const double node_cost = (double)pen_node_cost, root = e->root;
    const uint32_t begin = part * e->each;
    struct expected sum = {part == 0 ? node_cost : 0, 0};
    for (uint32_t node = begin; node < layout->nodes.count && node - begin < e->each; node++) {
        struct pen_child_box in;
        for (int lane = 0; lane < PEN_WIDE; lane++) {
            if (!pen_tree_layout_child(layout, node, lane, &in))
                continue;
            const double probability = root > 0 ? pen_child_box_half_area(&in) / root : 1;
            if (in.child & PEN_CHILD_LEAF)
                add_leaf(layout, &leaves[in.child & ~PEN_CHILD_LEAF], probability, &sum);
            else
                sum.cost += probability * node_cost;
        }
    }
    e->part[part] = sum;
}

static struct expected expect(const struct pen_tree_layout *layout)
{
    const uint32_t nodes = layout->nodes.count, least = pen_parts_of(nodes, PARTS);
    struct expecting e = {.layout = layout,
                          .root = pen_tree_layout_half_area(layout),
                          .each = least > NODES_LEAST ? least : NODES_LEAST};
    pen_parts_do(layout->pool, pen_parts_of(nodes, e.each), expect_part, &e);
    for (uint32_t i = 1; i < pen_parts_of(nodes, e.each); i++) {
        e.part[0].cost += e.part[i].cost;
        e.part[0].without_lanes += e.part[i].without_lanes;
    }
    return e.part[0];
}

void pen_auto_expect(const struct pen_tree_layout *layout, double cost[PEN_AUTO_COUNT])
{
    double alone, packet;
    cost_of_infinite(layout, &alone, &packet);
    cost[PEN_AUTO_NONE] = ray + alone + cost_of_list(layout);
    cost[PEN_AUTO_TREE] = cost[PEN_AUTO_PACKETS] = INFINITY;
    if (layout->shape != PEN_SHAPE_WIDE)
        return;
    const struct expected in_tree = expect(layout);
    const double q = reach * in_tree.without_lanes < 1 ? reach * in_tree.without_lanes : 1;
    const double together = ray_in_packet + packet + share * in_tree.cost;
    cost[PEN_AUTO_TREE] = ray + tree + alone + in_tree.cost;
    cost[PEN_AUTO_PACKETS] = (1 - q) * together + q * (cost[PEN_AUTO_TREE] + given_up);
}

enum pen_auto_choice pen_auto_choose(const double expected[PEN_AUTO_COUNT])
{
    int least = 0;
    for (int i = 1; i < PEN_AUTO_COUNT; i++)
        least = expected[i] < expected[least] ? i : least;
    return (enum pen_auto_choice)least;
}
