/* SPDX-License-Identifier: MIT */
/* Draws the growth of costs, as an SVG of panels with logarithmic axes.
 *
 * usage: growth_chart < POINTS > CHART.svg
 *
 * A line of POINTS is PANEL tab SERIES tab X tab Y, X and Y > 0. Panels are in the order of their
 * first points, three in a row. The points of a series are joined in their order. A grey line from
 * a panel's first point shows proportional growth. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { POINTS_MAX = 1000, NAME = 40, ROW = 3, WIDTH = 300, HEIGHT = 230, LEFT = 52, TOP = 30 };
enum { PLOT_WIDTH = WIDTH - LEFT - 16, PLOT_HEIGHT = HEIGHT - TOP - 34 };

struct point {
    char panel[NAME], series[NAME];
    double x, y;
};

struct panel {
    const char *name;
    double left, top;
    double x0, x1, y0, y1; /* powers of ten around the points */
};

static struct point point[POINTS_MAX];
static int count;

static void read_points(void)
{
    while (count < POINTS_MAX && scanf(" %39[^\t] %39[^\t] %lf %lf", point[count].panel,
                                       point[count].series, &point[count].x, &point[count].y) == 4)
        count++;
}

static double px(const struct panel *p, double x)
{
    return p->left + LEFT + (log10(x) - p->x0) / (p->x1 - p->x0) * PLOT_WIDTH;
}

static double py(const struct panel *p, double y)
{
    return p->top + TOP + (p->y1 - log10(y)) / (p->y1 - p->y0) * PLOT_HEIGHT;
}

static struct panel measure(const char *name, int number)
{
    struct panel p = {name, number % ROW * WIDTH, number / ROW * HEIGHT, 99, -99, 99, -99};
    for (int i = 0; i < count; i++) {
        if (strcmp(point[i].panel, name) != 0)
            continue;
        p.x0 = fmin(p.x0, floor(log10(point[i].x)));
        p.x1 = fmax(p.x1, ceil(log10(point[i].x)));
        p.y0 = fmin(p.y0, floor(log10(point[i].y)));
        p.y1 = fmax(p.y1, ceil(log10(point[i].y)));
    }
    p.x1 = fmax(p.x1, p.x0 + 1);
    p.y1 = fmax(p.y1, p.y0 + 1);
    return p;
}

static void draw_axes(const struct panel *p)
{
    double right = p->left + LEFT + PLOT_WIDTH, bottom = p->top + TOP + PLOT_HEIGHT;
    printf("<text x='%g' y='%g' class='name'>%s</text>\n", p->left + LEFT, p->top + 18, p->name);
    for (double e = p->x0; e <= p->x1; e++) {
        double x = px(p, pow(10, e));
        printf("<path d='M%g %gV%g' class='grid'/><text x='%g' y='%g' class='x'>%g</text>\n", x,
               p->top + TOP, bottom, x, bottom + 14, pow(10, e));
    }
    for (double e = p->y0; e <= p->y1; e++) {
        double y = py(p, pow(10, e));
        printf("<path d='M%g %gH%g' class='grid'/><text x='%g' y='%g' class='y'>%g</text>\n",
               p->left + LEFT, y, right, p->left + LEFT - 4, y + 4, pow(10, e));
    }
}

/* y = x y0 / x0 as far as the panel goes. */
static void draw_proportion(const struct panel *p, const struct point *from)
{
    double top = pow(10, p->y1), right = pow(10, p->x1);
    double x = fmin(right, top / from->y * from->x);
    printf("<path d='M%g %gL%g %g' class='linear'/>\n", px(p, from->x), py(p, from->y), px(p, x),
           py(p, from->y * x / from->x));
}

static void draw_series(const struct panel *p, const char *series, int number)
{
    static const char *const colour[4] = {"#1769aa", "#c2410c", "#4d7c0f", "#7e22ce"};
    const char *move = "M";
    const struct point *last = NULL;
    printf("<path fill='none' stroke-width='2' stroke='%s' d='", colour[number % 4]);
    for (int i = 0; i < count; i++) {
        if (strcmp(point[i].panel, p->name) != 0 || strcmp(point[i].series, series) != 0)
            continue;
        printf("%s%g %g", move, px(p, point[i].x), py(p, point[i].y));
        move = "L";
        last = &point[i];
    }
    printf("'/>\n");
    if (last)
        printf("<text x='%g' y='%g' class='y' fill='%s'>%s</text>\n", px(p, last->x),
               py(p, last->y) - 5, colour[number % 4], series);
}

/* Whether an earlier point is of the same panel, and of the same series if `series`. */
static int seen(int i, int series)
{
    for (int k = 0; k < i; k++) {
        if (!strcmp(point[k].panel, point[i].panel) &&
            (!series || !strcmp(point[k].series, point[i].series)))
            return 1;
    }
    return 0;
}

static void draw_panel(int first, int number)
{
    struct panel p = measure(point[first].panel, number);
    int series = 0;
    draw_axes(&p);
    draw_proportion(&p, &point[first]);
    for (int i = first; i < count; i++) {
        if (!strcmp(point[i].panel, p.name) && !seen(i, 1))
            draw_series(&p, point[i].series, series++);
    }
}

int main(void)
{
    int panels = 0;
    read_points();
    for (int i = 0; i < count; i++)
        panels += !seen(i, 0);
    printf(
        "<svg xmlns='http://www.w3.org/2000/svg' width='%d' height='%d' "
        "font-family='sans-serif' font-size='11'>\n"
        "<style>.grid{stroke:#ddd}.linear{stroke:#999;stroke-dasharray:4 4}.x{text-anchor:middle}"
        ".y{text-anchor:end}.name{font-weight:bold}</style>\n"
        "<rect width='100%%' height='100%%' fill='white'/>\n",
        ROW * WIDTH, (panels + ROW - 1) / ROW * HEIGHT);
    panels = 0;
    for (int i = 0; i < count; i++) {
        if (!seen(i, 0))
            draw_panel(i, panels++);
    }
    printf("</svg>\n");
    return count ? 0 : 1;
}
