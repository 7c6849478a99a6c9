// The orders of odeint's rosenbrock4 with constant steps: on an equation that depends on time, on one that does not, and on
// the first with the coefficient d4 of RODAS (Hairer and Wanner, Solving Ordinary Differential Equations II).

#include <boost/numeric/odeint.hpp>
#include <cmath>
#include <cstdio>

using namespace boost::numeric::odeint;
using Vector = boost::numeric::ublas::vector<double>;
using Matrix = boost::numeric::ublas::matrix<double>;

struct Rodas : default_rosenbrock_coefficients<double> {
    const double d4 = -0.3620000000000023e-01;
};

// The error of y' = (square - 1) y + force cos 3t - square y^2 at t = 2, from y = 1.
template <class Stepper>
double error(int steps, double force, double square, double exact) {
    Stepper stepper;
    Vector y(1, 1.0), next(1);
    const auto f = [=](const Vector &y, Vector &dy, double t) { dy[0] = (square - 1) * y[0] + force * std::cos(3 * t) - square * y[0] * y[0]; };
    const auto jacobian = [=](const Vector &y, Matrix &J, double t, Vector &dt) {
        J(0, 0) = square - 1 - 2 * square * y[0];
        dt[0] = -3 * force * std::sin(3 * t);
    };
    for (int i = 0; i < steps; i++) {
        stepper.do_step(std::make_pair(f, jacobian), y, 2.0 * i / steps, next, 2.0 / steps);
        y = next;
    }
    return std::fabs(y[0] - exact);
}

template <class Stepper>
double order(double force, double square, double exact) {
    return std::log2(error<Stepper>(16, force, square, exact) / error<Stepper>(32, force, square, exact));
}

int main() {
    const double forced = 0.9 * std::exp(-2.0) + (std::cos(6.0) + 3 * std::sin(6.0)) / 10;  // square = 0
    const double free = 1.0 / 3;                                                            // y' = -y^2: square = 1
    std::printf("%.3f %.3f %.3f\n", order<rosenbrock4<double>>(1, 0, forced), order<rosenbrock4<double>>(0, 1, free),
                order<rosenbrock4<double, Rodas>>(1, 0, forced));
}
