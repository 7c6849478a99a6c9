// Boost's odeint on five cases: `odeint dopri5`, or another of METHODS.
//
// As its tutorial drives it: controlled steppers with a first step of 0.01, and integrate_times, which shortens a step to
// end at a sample. The tolerance is the relative error; the absolute error is 1e-4 of it for the Runge-Kutta pairs (the
// tutorial's 1e-10 and 1e-6), and equal to it for the others (the default of bulirsch_stoer, the tutorial's rosenbrock4).
// rosenbrock4 has the Jacobian in closed form.

#include <boost/numeric/odeint.hpp>
#include <boost/version.hpp>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "serve.h"

using namespace boost::numeric::odeint;
using State = std::vector<double>;
using Vector = boost::numeric::ublas::vector<double>;
using Matrix = boost::numeric::ublas::matrix<double>;

static void slopes(Problem *problem, const double *y, double *dy, double t) {
    if (!slopes_of(problem, t, y, dy)) throw std::runtime_error("a slope is not finite");
}

template <class Stepper, class System, class Y>
void integrate(Problem *problem, Stepper stepper, System system, Y y) {
    std::vector<double> times(1, problem->t0);
    times.insert(times.end(), problem->times, problem->times + problem->samples);
    std::copy(problem->start, problem->start + y.size(), y.begin());
    bool begun = false;
    const auto keep = [&](const Y &at, double) {
        if (begun) std::copy(at.begin(), at.end(), problem->states[problem->reached++]);
        begun = true;
    };
    try {
        problem->steps = integrate_times(stepper, system, y, times.begin(), times.end(), 0.01, keep);
    } catch (const std::exception &error) {
        std::string reason = error.what();
        for (char &letter : reason)
            if (letter == '"' || letter == '\\' || letter == '\n') letter = ' ';
        std::snprintf(problem->reason, sizeof problem->reason, "%s", reason.c_str());
    }
}

template <class Stepper>
void explicitly(Problem *problem, Stepper stepper) {
    const auto system = [=](const State &y, State &dy, double t) { slopes(problem, y.data(), dy.data(), t); };
    integrate(problem, stepper, system, State(problem->of->n));
}

template <class Pair>
void pair(Problem *problem) {
    explicitly(problem, make_controlled<Pair>(1e-4 * problem->tolerance, problem->tolerance));
}

static void extrapolation(Problem *problem) {
    explicitly(problem, bulirsch_stoer<State>(problem->tolerance, problem->tolerance));
}

static void rosenbrock(Problem *problem) {
    const auto system = [=](const Vector &y, Vector &dy, double t) { slopes(problem, &y[0], &dy[0], t); };
    const auto jacobian = [=](const Vector &y, Matrix &J, double t, Vector &dt) {
        J.clear();
        dt.clear();
        problem->of->jacobian(t, &y[0], problem->p, &J.data()[0], &dt[0]);
    };
    const auto stepper = make_controlled<rosenbrock4<double>>(problem->tolerance, problem->tolerance);
    integrate(problem, stepper, std::make_pair(system, jacobian), Vector(problem->of->n));
}

int main(int count, char **words) {
    const std::map<std::string, void (*)(Problem *)> METHODS = {
        {"dopri5", pair<runge_kutta_dopri5<State>>},
        {"fehlberg78", pair<runge_kutta_fehlberg78<State>>},
        {"bulirsch_stoer", extrapolation},
        {"rosenbrock4", rosenbrock},
    };
    const auto method = METHODS.find(count == 2 ? words[1] : "");
    if (method == METHODS.end()) {
        std::fputs("usage: odeint dopri5|fehlberg78|bulirsch_stoer|rosenbrock4\n", stderr);
        return 2;
    }
    const std::string description =
        "{\"protocol\": 1, \"name\": \"odeint " + method->first + "\", \"version\": \"Boost " BOOST_LIB_VERSION
        "\", \"counts_rhs\": true, \"sampling\": \"stops at samples\","
        " \"sweep\": {\"kind\": \"tolerance\", \"loosest\": 1e-3, \"tightest\": 1e-13}}";
    serve(description.c_str(), method->second);
}
