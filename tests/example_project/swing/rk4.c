/* The classical Runge-Kutta method of order 4 on the pendulum and on Kepler's problem: a program that gnomon can verify. */

#include "lines.h"

enum { SAMPLES = 64, MOST = 4 };

static double g, L, mu;
static long calls;

static void pendulum(const double *y, double *dy) {
    dy[0] = y[1];
    dy[1] = -(g / L) * sin(y[0]);
}

static void kepler(const double *y, double *dy) {
    double square = y[0] * y[0] + y[1] * y[1], pull = -mu / (square * sqrt(square));
    dy[0] = y[2];
    dy[1] = y[3];
    dy[2] = pull * y[0];
    dy[3] = pull * y[1];
}

static void step(void (*f)(const double *, double *), int n, double *y, double h) {
    double k[4][MOST], z[MOST];
    const double at[4] = {0, 0.5, 0.5, 1};
    for (int stage = 0; stage < 4; stage++) {
        for (int i = 0; i < n; i++) z[i] = stage ? y[i] + at[stage] * h * k[stage - 1][i] : y[i];
        f(z, k[stage]);
        calls++;
    }
    for (int i = 0; i < n; i++) y[i] += h / 6 * (k[0][i] + 2 * k[1][i] + 2 * k[2][i] + k[3][i]);
}

static void solve(const char *line) {
    double y[MOST], times[SAMPLES], t = strtod(after(line, "t0"), NULL), h = strtod(after(line, "value"), NULL);
    int number = atoi(after(line, "number"));
    void (*f)(const double *, double *);
    if (strstr(line, "\"case\": \"pendulum_simple\"")) {
        f = pendulum, g = strtod(after(line, "g"), NULL), L = strtod(after(line, "L"), NULL);
    } else if (strstr(line, "\"case\": \"kepler_orbit\"")) {
        f = kepler, mu = strtod(after(line, "mu"), NULL);
    } else {
        printf("{\"number\": %d, \"status\": \"unsupported\", \"lacks\": \"this case\"}\n", number);
        return;
    }
    if (!(h > 0)) {
        printf("{\"number\": %d, \"status\": \"refused\", \"reason\": \"the step size is not positive\"}\n", number);
        return;
    }
    int n = numbers(after(line, "start"), y, MOST), samples = numbers(after(line, "times"), times, SAMPLES);
    long steps = calls = 0;
    printf("{\"number\": %d, \"status\": \"ok\", \"states\": [", number);
    for (int k = 0; k < samples; k++) {
        long count = lround(ceil((times[k] - t) / h - 1e-9));
        for (long i = 0; i < count; i++) step(f, n, y, (times[k] - t) / count);
        steps += count, t = times[k];
        fputs(k ? ", " : "", stdout);
        write_state(y, n);
    }
    printf("], \"steps\": %ld, \"rhs_calls\": %ld}\n", steps, calls);
}

int main(void) {
    static char line[1 << 20];
    while (fgets(line, sizeof line, stdin)) {
        if (strstr(line, "\"request\": \"describe\""))
            puts("{\"protocol\": 1, \"name\": \"RK4 in C\", \"order\": 4, \"counts_rhs\": true,"
                 " \"sweep\": {\"kind\": \"step\", \"coarsest\": 0.25, \"halvings\": 7}}");
        else
            solve(line);
        fflush(stdout);
    }
    return 0;
}
