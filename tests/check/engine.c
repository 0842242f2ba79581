/* A rigid top on a plane, by RK4: a test engine with planted faults.

   usage: engine RATE STEPS_PER_ROW UNTIL LAW FAULT m R alpha I1 I3 g mu theta theta_dot phi_dot omega_3
   State: quaternion, angular velocity (inertial), centre of mass, its velocity. Rigid contact (the
   normal force keeps the lowest point on the table), or soft: LAW "soft" is Coulomb on a spring. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static double m, R, alpha, I1, I3, g, mu;
static const char *law, *fault;
static int lost; /* a rigid table would have to pull: the run ends */
static int is(const char *name) { return !strcmp(fault, name); }
static void cross(const double *a, const double *b, double *c) {
    c[0] = a[1]*b[2] - a[2]*b[1]; c[1] = a[2]*b[0] - a[0]*b[2]; c[2] = a[0]*b[1] - a[1]*b[0];
}
static double dot(const double *a, const double *b) { return a[0]*b[0] + a[1]*b[1] + a[2]*b[2]; }
static void axis(const double *q, double *k) {
    k[0] = 2*(q[1]*q[3] + q[0]*q[2]); k[1] = 2*(q[2]*q[3] - q[0]*q[1]);
    k[2] = q[0]*q[0] + q[3]*q[3] - q[1]*q[1] - q[2]*q[2];
}
static double friction(double v) { /* force over normal force and speed */
    if (!strcmp(law, "viscous")) return mu;
    if (!strcmp(law, "regularised")) return mu/sqrt(v*v + 1e-4);
    if (!strcmp(law, "stribeck")) return (mu + 0.5*mu*exp(-v*v/0.01))/sqrt(v*v + 1e-4);
    return mu/sqrt(v*v + 1e-6); /* Coulomb's, but below 1 mm/s */
}
static void inverse_inertia(const double *k, const double *torque, double *w) {
    double along = dot(torque, k);
    for (int i = 0; i < 3; i++) w[i] = torque[i]/I1 + along*(1/I3 - 1/I1)*k[i];
}
static void rates(const double *y, double *d) {
    const double *q = y, *w = y + 4, *v = y + 10;
    double k[3], a[3], ad[3], L[3], va[3], gyro[3], unit[3], t[3], turn[3], x[3];
    axis(q, k);
    for (int i = 0; i < 3; i++) { a[i] = R*alpha*k[i]; L[i] = I1*w[i] + (I3 - I1)*dot(w, k)*k[i]; }
    cross(w, a, ad); a[2] -= R;
    cross(w, a, va);
    for (int i = 0; i < 3; i++) va[i] += v[i];
    cross(w, L, gyro);
    if (is("no gyroscopic term")) memset(gyro, 0, sizeof gyro);
    double drag = is("damped motion") ? 0.02 : 0;
    double f = friction(hypot(va[0], va[1])) * (is("friction pushes") ? -1 : 1), n;
    double per[3] = {-f*va[0], -f*va[1], 1}, lever[3] = {a[0], a[1], a[2]};
    if (is("centre of mass at the centre")) { lever[0] = lever[1] = 0; lever[2] = -R; }
    if (is("the force at the table")) lever[2] -= fmin(y[9] + a[2], 0);
    if (is("the force below the lowest point")) lever[2] += fmin(y[9] + a[2], 0);
    cross(lever, per, t); inverse_inertia(k, t, unit);
    for (int i = 0; i < 3; i++) gyro[i] = -gyro[i];
    inverse_inertia(k, gyro, turn);
    if (!strcmp(law, "soft")) {
        double h = y[9] + a[2]; n = fmax(0, -2e5*m*h - 200*m*va[2]);
    } else { /* the lowest point keeps its height: its vertical acceleration vanishes */
        double free[3], push[3]; cross(turn, a, free); cross(unit, a, push); cross(w, ad, x);
        n = (g + drag*v[2] - free[2] - x[2])/(1/m + push[2]);
    }
    if (is("normal force is the weight")) n = m*g;
    if (n < 0 && !is("the table pulls")) lost = 1;
    d[0] = -(w[0]*q[1] + w[1]*q[2] + w[2]*q[3])/2; d[1] = (w[0]*q[0] + w[1]*q[3] - w[2]*q[2])/2;
    d[2] = (w[1]*q[0] + w[2]*q[1] - w[0]*q[3])/2;  d[3] = (w[2]*q[0] + w[0]*q[2] - w[1]*q[1])/2;
    double drill[3] = {0, 0, is("torsional friction") ? -1e-3*m*g*R*(w[2] > 0 ? 1 : -1) : 0}, s[3];
    for (int i = 0; i < 3 && (drag || is("damped momentum")); i++) drill[i] = -0.02*L[i];
    inverse_inertia(k, drill, s);
    for (int i = 0; i < 3; i++) {
        d[4+i] = turn[i] + n*unit[i] + s[i]; d[7+i] = v[i]; d[10+i] = n*per[i]/m - drag*v[i];
    }
    d[12] -= g;
}
static void row(double time, const double *y) {
    double q[4], w[3], v[3], p[3], k[3], s[3], half = rand();
    memcpy(q, y, sizeof q); memcpy(w, y+4, sizeof w); memcpy(p, y+7, sizeof p); memcpy(v, y+10, sizeof v);
    axis(q, k);
    if (is("spin angle at random")) { /* turned about its own axis: q times (cos, 0, 0, sin) */
        double c = cos(half), z = sin(half), o[4] = {q[0], q[1], q[2], q[3]};
        q[0] = o[0]*c - o[3]*z; q[1] = o[1]*c + o[2]*z; q[2] = o[2]*c - o[1]*z; q[3] = o[3]*c + o[0]*z;
    }
    if (is("z is five metres")) p[2] = 5;
    if (is("position stands still")) p[0] = p[1] = 0;
    if (is("quaternion with its scalar last")) { double o = q[0]; q[0] = q[1]; q[1] = q[2]; q[2] = q[3]; q[3] = o; }
    if (is("velocity of the centre of the sphere")) { for (int i = 0; i < 3; i++) k[i] *= R*alpha; cross(w, k, s); for (int i = 0; i < 3; i++) v[i] += s[i]; }
    if (is("angular velocity in the body frame")) { /* w - 2 q_v x (q_w w - q_v x w) */
        double u[3] = {-q[1], -q[2], -q[3]}, c[3], e[3]; cross(u, w, c); cross(u, c, e);
        for (int i = 0; i < 3; i++) w[i] += 2*(q[0]*c[i] + e[i]);
    }
    printf("%.17g", time);
    for (int i = 0; i < 4; i++) printf(",%.17g", q[i]);
    for (int i = 0; i < 3; i++) printf(",%.17g", w[i]);
    for (int i = 0; i < 3; i++) printf(",%.17g", v[i]);
    printf(",%.17g,%.17g,%.17g\n", p[0], p[1], p[2]);
}
int main(int count, char **argv) {
    if (count != 17) return 2;
    double rate = atof(argv[1]), until = atof(argv[3]), *body[] = {&m, &R, &alpha, &I1, &I3, &g, &mu};
    int inner = atoi(argv[2]); law = argv[4]; fault = argv[5];
    for (int i = 0; i < 7; i++) *body[i] = atof(argv[6+i]);
    double theta = atof(argv[13]), td = atof(argv[14]), pd = atof(argv[15]), w3 = atof(argv[16]);
    double c = cos(theta), s = sin(theta), h = 1/(rate*inner);
    double y[13] = {cos(theta/2), 0, sin(theta/2), 0, -pd*s*c + w3*s, td, pd*s*s + w3*c, 0, 0, R*(1 - alpha*c), 0, 0, R*alpha*s*td};
    { double a[3] = {R*alpha*s, 0, R*alpha*c - R}, va[3]; cross(y+4, a, va); y[10] = -va[0]; y[11] = -va[1]; }
    if (is("I1 a hundredth more")) I1 *= 1.01;
    if (is("I3 a hundredth more")) I3 *= 1.01;
    if (is("gravity is 9")) g = 9;
    if (is("alpha a hundredth more")) { alpha *= 1.01; y[9] = R*(1 - alpha*c); y[12] *= 1.01; }
    if (is("mass a tenth more")) m *= 1.1;
    if (is("mu a tenth more")) mu *= 1.1;
    puts("t,qw,qx,qy,qz,wx,wy,wz,vcx,vcy,vcz,x,y,z");
    for (int n = 0; n <= until*rate + 1e-9; n++) {
        if (lost) break;
        row(n/rate, y);
        for (int j = 0; j < inner; j++) {
            double k1[13], k2[13], k3[13], k4[13], z[13];
            rates(y, k1);
            for (int i = 0; i < 13; i++) z[i] = y[i] + h/2*k1[i];
            rates(z, k2);
            for (int i = 0; i < 13; i++) z[i] = y[i] + h/2*k2[i];
            rates(z, k3);
            for (int i = 0; i < 13; i++) z[i] = y[i] + h*k3[i];
            rates(z, k4);
            for (int i = 0; i < 13; i++) y[i] += h/6*(k1[i] + 2*k2[i] + 2*k3[i] + k4[i]);
            double norm = sqrt(y[0]*y[0] + y[1]*y[1] + y[2]*y[2] + y[3]*y[3]);
            for (int i = 0; i < 4; i++) y[i] /= norm;
        }
    }
    return 0;
}
