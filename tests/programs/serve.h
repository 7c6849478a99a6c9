/* The lines that gnomon and a program exchange (docs/any_language.md), for programs that solve the five cases. */

#include "../example_project/swing/lines.h"
#include "five_cases.h"

enum { SAMPLES = 64 };

typedef struct {
    const Case *of;
    double p[MOST], start[MOST], t0, times[SAMPLES], tolerance;
    int samples;
    /* The answer: `reached` rows of states, and a reason if these are not all. */
    double states[SAMPLES][MOST];
    int reached;
    long steps, calls;
    char reason[200];
} Problem;

/* The slopes at a state, counted. 0 if one is not finite. */
static int slopes_of(Problem *problem, double t, const double *y, double *dy) {
    int finite = 1;
    problem->calls++;
    problem->of->slopes(t, y, problem->p, dy);
    for (int i = 0; i < problem->of->n; i++) finite = finite && isfinite(dy[i]);
    return finite;
}

/* Read a problem. 0, and a reply, if it cannot be solved. */
static int read_problem(const char *line, Problem *problem, int number) {
    char name[64] = "";
    sscanf(after(line, "case"), "\"%63[^\"]", name);
    problem->of = find_case(name);
    if (problem->of == NULL) {
        printf("{\"number\": %d, \"status\": \"unsupported\", \"lacks\": \"this case\"}\n", number);
        return 0;
    }
    if (numbers(after(line, "value"), &problem->tolerance, 1) == 0 || !(problem->tolerance > 0)) {
        printf("{\"number\": %d, \"status\": \"refused\", \"reason\": \"the tolerance is not positive\"}\n", number);
        return 0;
    }
    for (int k = 0; k < MOST && problem->of->parameters[k]; k++)
        numbers(after(line, problem->of->parameters[k]), problem->p + k, 1);
    numbers(after(line, "start"), problem->start, MOST);
    numbers(after(line, "t0"), &problem->t0, 1);
    problem->samples = numbers(after(line, "times"), problem->times, SAMPLES);
    problem->reached = 0, problem->steps = problem->calls = 0, problem->reason[0] = '\0';
    return 1;
}

static void write_reply(const Problem *problem, int number) {
    const int stopped = problem->reached < problem->samples;
    printf("{\"number\": %d, \"status\": \"%s\", \"states\": [", number, stopped ? "stopped" : "ok");
    for (int k = 0; k < problem->reached; k++) {
        fputs(k ? ", " : "", stdout);
        write_state(problem->states[k], problem->of->n);
    }
    printf("], \"steps\": %ld, \"rhs_calls\": %ld", problem->steps, problem->calls);
    if (stopped) printf(", \"reason\": \"%s\"", problem->reason);
    printf("}\n");
}

/* Answer line after line: `description`, or the problem that `solve` solves. */
static void serve(const char *description, void (*solve)(Problem *)) {
    static char line[1 << 20];
    static Problem problem;
    while (fgets(line, sizeof line, stdin)) {
        const int number = atoi(after(line, "number"));
        if (strstr(line, "\"request\": \"describe\""))
            puts(description);
        else if (read_problem(line, &problem, number)) {
            solve(&problem);
            write_reply(&problem, number);
        }
        fflush(stdout);
    }
}
