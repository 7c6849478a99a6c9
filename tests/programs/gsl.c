/* The GNU Scientific Library on five cases: `gsl rk8pd`, or another of METHODS.
 *
 * As the manual's first example drives it (chapter "Ordinary Differential Equations"): gsl_odeiv2_driver_alloc_y_new with a
 * first step of 1e-6, the tolerance as the absolute error and a relative error of 0; gsl_odeiv2_driver_apply from sample
 * to sample, which shortens a step to end there. The methods that use the Jacobian have it in closed form. */

#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>
#include <gsl/gsl_version.h>

#include "serve.h"

static const gsl_odeiv2_step_type *method;

static int slopes(double t, const double y[], double dy[], void *problem) {
    return slopes_of((Problem *)problem, t, y, dy) ? GSL_SUCCESS : GSL_EBADFUNC;
}

static int jacobian(double t, const double y[], double *J, double dt[], void *given) {
    const Problem *problem = (const Problem *)given;
    const int n = problem->of->n;
    memset(J, 0, sizeof(double) * n * n);
    memset(dt, 0, sizeof(double) * n);
    problem->of->jacobian(t, y, problem->p, J, dt);
    return GSL_SUCCESS;
}

static void solve(Problem *problem) {
    gsl_odeiv2_system system = {slopes, jacobian, (size_t)problem->of->n, problem};
    gsl_odeiv2_driver *driver = gsl_odeiv2_driver_alloc_y_new(&system, method, 1e-6, problem->tolerance, 0.0);
    double t = problem->t0, y[MOST];
    memcpy(y, problem->start, sizeof y);
    for (; problem->reached < problem->samples; problem->reached++) {
        const int status = gsl_odeiv2_driver_apply(driver, &t, problem->times[problem->reached], y);
        if (status != GSL_SUCCESS) {
            snprintf(problem->reason, sizeof problem->reason, "%s at t = %g", gsl_strerror(status), t);
            break;
        }
        memcpy(problem->states[problem->reached], y, sizeof y);
    }
    problem->steps = (long)driver->e->count;
    gsl_odeiv2_driver_free(driver);
}

int main(int count, char **words) {
    const struct { const char *name; const gsl_odeiv2_step_type *type; } METHODS[] = {
        {"rkf45", gsl_odeiv2_step_rkf45}, {"rk8pd", gsl_odeiv2_step_rk8pd}, {"msadams", gsl_odeiv2_step_msadams},
        {"bsimp", gsl_odeiv2_step_bsimp}, {"msbdf", gsl_odeiv2_step_msbdf},
    };
    char description[300];
    for (unsigned k = 0; k < sizeof METHODS / sizeof *METHODS; k++)
        if (count == 2 && strcmp(words[1], METHODS[k].name) == 0) method = METHODS[k].type;
    if (method == NULL) {
        fputs("usage: gsl rkf45|rk8pd|msadams|bsimp|msbdf\n", stderr);
        return 2;
    }
    gsl_set_error_handler_off();
    snprintf(description, sizeof description,
             "{\"protocol\": 1, \"name\": \"GSL %s\", \"version\": \"GSL %s\", \"counts_rhs\": true,"
             " \"sampling\": \"stops at samples\", \"sweep\": {\"kind\": \"tolerance\", \"loosest\": 1e-3, \"tightest\": 1e-13}}",
             words[1], gsl_version);
    serve(description, solve);
    return 0;
}
