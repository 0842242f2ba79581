/* A complete engine for the protocol of tt-precise engines --run, in C99: rigid contact, Coulomb
   friction while the contact glides, the Runge-Kutta method of order 4. No JSON library is needed:
   a job has every key once, and its value follows the key.

       cc -O2 -o engine examples/engine.c -lm && tt-precise engines --run ./engine --test ice */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SLOW 1e-2 /* m/s: below it friction is proportional to the gliding speed */
#define SIZE 10   /* quaternion (scalar first), angular velocity, velocity of the centre of mass */

static char text[1 << 20];
static double m, R, c, I1, I3, g, mu, h;
static int flying, viscous;

static const char *after(const char *key)
{
    char quoted[40];
    snprintf(quoted, sizeof quoted, "\"%s\":", key);
    const char *found = strstr(text, quoted);
    if (!found) {
        fprintf(stderr, "the job has no %s\n", key);
        exit(1);
    }
    return found + strlen(quoted);
}

static double number(const char *key) { return strtod(after(key), NULL); }

static void numbers(const char *key, double *into, int count)
{
    char *at = strchr(after(key), '[');
    for (int i = 0; i < count; i++)
        into[i] = strtod(at + 1, &at);
}

static void cross(const double *a, const double *b, double *into)
{
    into[0] = a[1] * b[2] - a[2] * b[1];
    into[1] = a[2] * b[0] - a[0] * b[2];
    into[2] = a[0] * b[1] - a[1] * b[0];
}

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* I omega_dot = torque - omega x I omega, with I = I1 + (I3 - I1) k k */
static void omega_dot(const double *k, const double *w, const double *torque, double *into)
{
    double k_dot[3], push[3];
    cross(w, k, k_dot);
    for (int i = 0; i < 3; i++)
        push[i] = torque[i] - (I3 - I1) * dot(w, k) * k_dot[i];
    double along = (1 / I3 - 1 / I1) * dot(push, k);
    for (int i = 0; i < 3; i++)
        into[i] = push[i] / I1 + along * k[i];
}

/* Vertical acceleration of the sphere's centre under the force normal * direction at a. */
static double rise(const double *k, const double *w, const double *a, const double *direction,
                   double normal)
{
    double torque[3], turning[3], swung[3], k_dot[3], driven[3];
    cross(a, direction, torque);
    for (int i = 0; i < 3; i++)
        torque[i] *= normal;
    omega_dot(k, w, torque, turning);
    cross(turning, k, driven);
    cross(w, k, k_dot);
    cross(w, k_dot, swung);
    return normal / m - g + c * (driven[2] + swung[2]);
}

static void rates(const double *y, double *into)
{
    const double *q = y, *w = y + 4, *v = y + 7;
    double k[3] = {2 * (q[1] * q[3] + q[0] * q[2]), 2 * (q[2] * q[3] - q[0] * q[1]),
                   1 - 2 * (q[1] * q[1] + q[2] * q[2])};
    into[0] = -(q[1] * w[0] + q[2] * w[1] + q[3] * w[2]) / 2;
    into[1] = (q[0] * w[0] + q[3] * w[1] - q[2] * w[2]) / 2;
    into[2] = (q[0] * w[1] + q[1] * w[2] - q[3] * w[0]) / 2;
    into[3] = (q[0] * w[2] + q[2] * w[0] - q[1] * w[1]) / 2;
    double force[3] = {0, 0, 0}, torque[3] = {0, 0, 0};
    if (!flying) {
        double a[3] = {c * k[0], c * k[1], c * k[2] - R}, swing[3];
        cross(w, a, swing);
        double x = v[0] + swing[0], z = v[1] + swing[1];
        double ratio = viscous ? mu : mu / fmax(hypot(x, z), SLOW);
        double direction[3] = {-ratio * x, -ratio * z, 1};
        double free = rise(k, w, a, direction, 0);
        double normal = free / (free - rise(k, w, a, direction, 1));
        for (int i = 0; i < 3; i++)
            force[i] = normal * direction[i];
        cross(a, force, torque);
    }
    omega_dot(k, w, torque, into + 4);
    for (int i = 0; i < 3; i++)
        into[7 + i] = force[i] / m - (i == 2 ? g : 0);
}

static void step(double *y)
{
    static const double at[4] = {0, 0.5, 0.5, 1}, weight[4] = {1, 2, 2, 1};
    double rate[SIZE] = {0}, there[SIZE], sum[SIZE] = {0};
    for (int stage = 0; stage < 4; stage++) {
        for (int i = 0; i < SIZE; i++)
            there[i] = y[i] + at[stage] * h * rate[i];
        rates(there, rate);
        for (int i = 0; i < SIZE; i++)
            sum[i] += weight[stage] * rate[i];
    }
    for (int i = 0; i < SIZE; i++)
        y[i] += h / 6 * sum[i];
    double size = sqrt(y[0] * y[0] + y[1] * y[1] + y[2] * y[2] + y[3] * y[3]);
    for (int i = 0; i < 4; i++)
        y[i] /= size;
}

int main(void)
{
    text[fread(text, 1, sizeof text - 1, stdin)] = 0;
    m = number("mass"), R = number("radius"), c = number("centre_offset");
    I1 = number("I1"), I3 = number("I3"), g = number("gravity"), h = number("step");
    mu = number("mu");
    const char *law = strchr(after("law"), '"') + 1;
    viscous = !strncmp(law, "viscous\"", 8);
    flying = !strncmp(strchr(after("contact"), '"') + 1, "none\"", 5);
    if (!viscous && strncmp(law, "coulomb\"", 8) && strncmp(law, "none\"", 5)) {
        fprintf(stderr, "no such friction here\n");
        return 3;
    }
    double y[SIZE];
    numbers("quaternion_wxyz", y, 4);
    numbers("angular_velocity", y + 4, 3);
    numbers("velocity", y + 7, 3);
    puts("# engine: Runge and Kutta in C");
    puts("t,qw,qx,qy,qz,wx,wy,wz,vcx,vcy,vcz");
    long done = 0;
    char *at = strchr(after("sample_times"), '[');
    while (*at == '[' || *at == ',') {
        double t = strtod(at + 1, &at);
        for (; done < lround(t / h); done++)
            step(y);
        printf("%.17g", t);
        for (int i = 0; i < SIZE; i++)
            printf(",%.17g", y[i]);
        putchar('\n');
    }
    return 0;
}
