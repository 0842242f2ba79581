/* Reads the reference data from C99, test vectors and a trajectory, and computes the contact
   force of every state, under every law, with a dozen lines of physics.
   cc -O2 -o reader examples/readers/reader.c -lm && ./reader reference_data */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct { double x, y, z; } vector;

static double dot(vector a, vector b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static vector cross(vector a, vector b) {
    return (vector){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static vector sum(double c, vector a, vector b) {
    return (vector){c * a.x + b.x, c * a.y + b.y, c * a.z + b.z};
}
static char *slurp(const char *folder, const char *path) {
    char whole[1024], *text = calloc(1, 1 << 24);
    snprintf(whole, sizeof whole, "%s/%s", folder, path);
    FILE *file = fopen(whole, "rb");
    if (!file || !fread(text, 1, (1 << 24) - 1, file))
        exit((fprintf(stderr, "no file %s\n", path), 1));
    return text;
}
/* The numbers behind a key, which are printed as strings; 0 where a law has none. */
static vector get(const char *text, const char *key) {
    double three[3] = {0};
    char quoted[40];
    snprintf(quoted, sizeof quoted, "\"%s\": ", key);
    const char *at = strstr(text, quoted);
    at = at ? at + strlen(quoted) : "";
    for (int i = 0; i < 3; i++)
        three[i] = strtod(at + strcspn(at, "-0123456789"), (char **)&at);
    return (vector){three[0], three[1], three[2]};
}
static double number(const char *text, const char *key) {
    return get(text, key).x;
}
/* A force F accelerates the contact by b + p F - (a.F) a/I1 + d (n.F) n, which rolling makes 0. */
static vector force(const char *at, const char *law) {
    double m = number(at, "m"), R = number(at, "R"), I1 = number(at, "I1"), I3 = number(at, "I3");
    double lever = R * number(at, "alpha"), d = 1 / I3 - 1 / I1, mu = number(at, "mu");
    vector k = get(at, "k"), omega = get(at, "omega"), fall = {0, 0, -number(at, "g")};
    vector a = sum(lever, k, (vector){0, 0, -R}), n = cross(k, a), k_dot = cross(omega, k);
    vector v = sum(1, get(at, "s_dot"), cross(omega, a));
    vector b = sum(lever, cross(omega, k_dot), sum(d * I3 * dot(omega, k), cross(k_dot, a), fall));
    double p = 1 / m + dot(a, a) / I1, slip = hypot(hypot(v.x, v.y), number(at, "epsilon"));
    if (!strncmp(law, "rolling", 7) || *law == 's')
        return sum(d * dot(n, b) / (p + d * dot(n, n)) / p, n,
                   sum(-m * dot(a, b) / I1 / p, a, sum(-1 / p, b, (vector){0, 0, 0})));
    vector f = sum(-mu / (*law == 'v' ? 1 : slip), (vector){v.x, v.y, 0}, (vector){0, 0, 1});
    double g_n = *law == 'n' ? 0 : b.z / (dot(a, f) * a.z / I1 - p), depth = -number(at, "height");
    double c = number(at, "stiffness"), damping = number(at, "damping");
    if (*law == 'l') g_n = fmax(0, c * depth - damping * v.z);
    if (*law == 'h') g_n = c * pow(depth, 1.5) * fmax(0, 1 - damping * v.z);
    return sum(g_n, f, (vector){0, 0, 0});
}
int main(int count, char **words) {
    const char *folder = count > 1 ? words[1] : "reference_data", *name = "\"name\": \"";
    char *at = slurp(folder, "vectors/states.json");
    char *rows = slurp(folder, "reference/trajectory.csv");
    double worst = 0, count_of_rows = -1, states = 0; /* the header is no row */
    for (char *next = strstr(at, name); (at = next); states++) {
        if ((next = strstr(at + 1, name)))
            next[-1] = 0;
        vector off = sum(-1, get(at, "F"), force(at, at + strlen(name)));
        double size = sqrt(dot(off, off)) / number(at, "m") / number(at, "g");
        worst = fmax(worst, strstr(at, "\"invalid\"") ? size < 1e-9 : size); /* has to differ */
    }
    for (char *line = rows; (line = strchr(line, '\n')); line++)
        count_of_rows++;
    rows[strlen(rows) - 1] = 0; /* columns t, kx, ky, kz come first; the last line */
    vector k;
    sscanf(strrchr(rows, '\n') + 1, "%*[^,],%lf,%lf,%lf", &k.x, &k.y, &k.z);
    printf("%g states, %g rows: %g\n", states, count_of_rows, worst);
    return !(states && worst < 1e-12 && fabs(dot(k, k) - 1) < 1e-15);
}
