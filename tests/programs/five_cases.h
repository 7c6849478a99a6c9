/* Five cases of gnomon: slopes and Jacobians, with the parameters in the order of their names. */

#include <math.h>
#include <string.h>

enum { MOST = 5 };

typedef struct {
    const char *name;
    int n;
    const char *parameters[MOST];
    void (*slopes)(double t, const double *y, const double *p, double *dy);
    /* J, row by row, and the derivative by the time; both are zeros before. */
    void (*jacobian)(double t, const double *y, const double *p, double *J, double *dt);
} Case;

static void pendulum(double t, const double *y, const double *p, double *dy) {
    (void)t;
    dy[0] = y[1];
    dy[1] = -(p[0] / p[1]) * sin(y[0]);
}

static void pendulum_jacobian(double t, const double *y, const double *p, double *J, double *dt) {
    (void)t, (void)dt;
    J[1] = 1;
    J[2] = -(p[0] / p[1]) * cos(y[0]);
}

static void kepler(double t, const double *y, const double *p, double *dy) {
    const double square = y[0] * y[0] + y[1] * y[1], pull = -p[0] / (square * sqrt(square));
    (void)t;
    dy[0] = y[2];
    dy[1] = y[3];
    dy[2] = pull * y[0];
    dy[3] = pull * y[1];
}

static void kepler_jacobian(double t, const double *y, const double *p, double *J, double *dt) {
    const double square = y[0] * y[0] + y[1] * y[1], pull = -p[0] / (square * sqrt(square)), more = -3 * pull / square;
    (void)t, (void)dt;
    J[2] = J[7] = 1;
    J[8] = pull + more * y[0] * y[0];
    J[9] = J[12] = more * y[0] * y[1];
    J[13] = pull + more * y[1] * y[1];
}

static void damped(double t, const double *y, const double *p, double *dy) {
    (void)t;
    dy[0] = y[1];
    dy[1] = -(p[1] / p[0]) * y[1] - p[2] / p[0] * y[0];
}

static void damped_jacobian(double t, const double *y, const double *p, double *J, double *dt) {
    (void)t, (void)y, (void)dt;
    J[1] = 1;
    J[2] = -p[2] / p[0];
    J[3] = -p[1] / p[0];
}

static void duffing(double t, const double *y, const double *p, double *dy) {
    (void)t;
    dy[0] = y[1];
    dy[1] = -p[0] * y[0] - p[1] * y[0] * y[0] * y[0];
}

static void duffing_jacobian(double t, const double *y, const double *p, double *J, double *dt) {
    (void)t, (void)dt;
    J[1] = 1;
    J[2] = -p[0] - 3 * p[1] * y[0] * y[0];
}

static void forced(double t, const double *y, const double *p, double *dy) {
    damped(t, y, p, dy);
    dy[1] += p[3] / p[0] * cos(p[4] * t);
}

static void forced_jacobian(double t, const double *y, const double *p, double *J, double *dt) {
    damped_jacobian(t, y, p, J, dt);
    dt[1] = -p[3] / p[0] * p[4] * sin(p[4] * t);
}

static const Case CASES[] = {
    {"pendulum_simple", 2, {"g", "L"}, pendulum, pendulum_jacobian},
    {"kepler_orbit", 4, {"mu"}, kepler, kepler_jacobian},
    {"damped_oscillator", 2, {"m", "c", "k"}, damped, damped_jacobian},
    {"duffing_unforced", 2, {"alpha", "beta"}, duffing, duffing_jacobian},
    {"forced_oscillator", 2, {"m", "c", "k", "F0", "w"}, forced, forced_jacobian},
};

static const Case *find_case(const char *name) {
    for (unsigned k = 0; k < sizeof CASES / sizeof *CASES; k++)
        if (strcmp(CASES[k].name, name) == 0) return CASES + k;
    return NULL;
}
