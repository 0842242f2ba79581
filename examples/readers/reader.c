/* Reads the reference data from C99: the index, test vectors, a trajectory; and computes the
   force of every state that glides on a rigid table with ten lines of physics.
   cc -O2 -o reader examples/readers/reader.c -lm && ./reader reference_data */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static char *slurp(const char *folder, const char *path)
{
    char whole[1024];
    snprintf(whole, sizeof whole, "%s/%s", folder, path);
    FILE *file = fopen(whole, "rb");
    char *text = calloc(1, 1 << 24);
    if (!file || !fread(text, 1, (1 << 24) - 1, file))
        exit((fprintf(stderr, "no file %s\n", path), 1));
    return text;
}
/* The numbers behind a key, printed as strings, of the object that begins at `from`. */
static void get(const char *from, const char *key, double *into, int count)
{
    char quoted[40];
    snprintf(quoted, sizeof quoted, "\"%s\": ", key);
    const char *at = strstr(from, quoted);
    if (!at)
        exit((fprintf(stderr, "no %s\n", key), 1));
    at += strlen(quoted);
    for (int i = 0; i < count; i++)
        into[i] = strtod(at + strcspn(at, "-0123456789"), (char **)&at);
}
static void cross(const double *a, const double *b, double *c)
{
    for (int i = 0, j = 1, l = 2; i < 3; i++, j = (i + 1) % 3, l = (i + 2) % 3)
        c[i] = a[j] * b[l] - a[l] * b[j];
}
/* F = g_n (z - c v_A) at the contact point; c is mu, mu/|v_A| or regularised. */
static void force(const char *at, int viscous, int regularised, double *F)
{
    double m, R, alpha, I1, I3, g, mu, eps = 0;
    double k[3], w[3], v[3], L[3], swing[3], kd[3], s[3], t[3];
    get(at, "m", &m, 1), get(at, "R", &R, 1), get(at, "alpha", &alpha, 1), get(at, "mu", &mu, 1);
    get(at, "I1", &I1, 1), get(at, "I3", &I3, 1), get(at, "g", &g, 1);
    get(at, "k", k, 3), get(at, "omega", w, 3), get(at, "s_dot", v, 3);
    if (regularised)
        get(at, "epsilon", &eps, 1);
    double along = (I3 - I1) * (w[0] * k[0] + w[1] * k[1] + w[2] * k[2]);
    double a[3] = {R * alpha * k[0], R * alpha * k[1], R * alpha * k[2] - R};
    cross(w, a, swing), cross(w, k, kd);
    for (int i = 0; i < 3; i++)
        L[i] = I1 * w[i] + along * k[i], v[i] += swing[i];
    double c = viscous ? mu : mu / sqrt(v[0] * v[0] + v[1] * v[1] + eps * eps);
    double f[3] = {-c * v[0], -c * v[1], 1};
    cross(L, kd, s), cross(a, f, t), cross(t, k, swing);
    double g_n = (m * g * I1 - m * R * alpha * s[2]) / (I1 + m * R * alpha * swing[2]);
    for (int i = 0; i < 3; i++)
        F[i] = g_n * f[i];
}
int main(int count, char **words)
{
    char *folder = count > 1 ? words[1] : "reference_data";
    char *index = slurp(folder, "index.json"), *at = slurp(folder, "vectors/states.json");
    char *rows = slurp(folder, "reference/trajectory.csv");
    double F[3], known[3], k[3], worst = 0, files = 0, states = 0;
    for (; (index = strstr(index, "\"path\": ")); index++)
        files++;
    while ((at = strstr(at, "\"body\": {")) && ++at) {
        const char *law = strstr(at, "\"law\": \"") + 8, *contact = strstr(law, "\"law\": \"") + 8;
        if (*law == 'n' || *law == 's' || !strncmp(law, "rolling", 7) || *contact == 'c')
            continue; /* free flight, the force of a constraint, elastic tables */
        force(at, *law == 'v', *law == 'r', F), states++;
        get(strstr(at, "\"expected\""), "F", known, 3);
        for (int i = 0; i < 3; i++)
            worst = fmax(worst, fabs(F[i] - known[i]) / fabs(known[2]));
    }
    rows[strlen(rows) - 1] = 0; /* columns t, kx, ky, kz come first; the last line */
    sscanf(strrchr(rows, '\n') + 1, "%*[^,],%lf,%lf,%lf", k, k + 1, k + 2);
    printf("%g files, %g states: %g\n", files, states, worst);
    return !(files && states && worst < 1e-12 &&
             fabs(k[0] * k[0] + k[1] * k[1] + k[2] * k[2] - 1) < 1e-15);
}
