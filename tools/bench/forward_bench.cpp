// What a forward run costs, in seconds and as a multiple of one sparse Cholesky factorisation of its own matrix.
// All figures are medians of rounds in which each is measured once, in turn: the ratios hold where the machine drifts.
// usage: forward_bench STUDY [ROUNDS]
#include "fe/sparse_solver.h"
#include "run/blas.h"
#include "study/study.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fmt/format.h>

namespace {

using namespace pave;
using Element = fe::AxisymmetricQ8;

double seconds_of(const auto& action) {
    const auto begin = std::chrono::steady_clock::now();
    action();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

double median(std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
    return values[values.size() / 2];
}

// The stiffness matrix of the whole section at its initial stress, lower triangle.
std::vector<double> matrix_of(const pavement::Parts<pavement::Axisymmetric>& c) {
    std::vector<double> values(c.model.topology->lower.row.size(), 0.0);
    for (int e = 0; e < c.model.elements(); ++e) {
        const auto& layer = c.layers[static_cast<std::size_t>(c.model.topology->layer[e])];
        const mechanics::Stiffness<4> unit = layer.law->unit_stiffness(layer.parameters).topLeftCorner<4, 4>();
        Eigen::Matrix<double, Element::dofs, Element::dofs> k =
            Eigen::Matrix<double, Element::dofs, Element::dofs>::Zero();
        for (int g = 0; g < Element::gauss; ++g) {
            const int q = e * Element::gauss + g;
            const auto at = mechanics::invariants<4>(layer.initial_stress<4>(c.model.depth[q]));
            const auto b = Element::strain_operator(c.model.points[q]);
            const Element::Operator db =
                layer.law->modulus(layer.parameters, at).value * c.model.points[q].weight * (unit * b);
            k += b.transpose() * db;
        }
        int entry = 0;
        for (int i = 0; i < Element::dofs; ++i) {
            for (int j = 0; j <= i; ++j, ++entry) {
                if (const int place = c.model.topology->scatter[e][entry]; place >= 0) {
                    values[place] += k(i, j);
                }
            }
        }
    }
    return values;
}

} // namespace

int main(int argc, char** argv) {
    if (argc < 2) {
        fmt::print(stderr, "usage: forward_bench STUDY [ROUNDS]\n");
        return 2;
    }
    explore::run::prepare_blas();
    const int rounds = argc > 2 ? std::max(1, std::atoi(argv[2])) : 15;
    const auto study = explore::study::load_study(argv[1]);
    const pavement::ForwardModel model(study.model);
    const auto workspace = model.make_workspace();
    const auto parts = pavement::parts_of<pavement::Axisymmetric>(study.model, 0);
    const auto matrix = matrix_of(parts);
    fe::SparseCholesky cholesky(parts.model.topology->lower, *parts.model.topology->analysis);

    std::vector<double> factorization, forward, jacobian;
    for (int round = -1; round < rounds; ++round) { // the first warms up
        bool definite = true;
        const double a = seconds_of([&] {
                             for (int i = 0; i < 10; ++i) {
                                 definite = definite && cholesky.factorize(matrix);
                             }
                         }) /
                         10;
        bool converged = true;
        const double b = seconds_of([&] { converged = bool(model.run(study.model, {}, *workspace)); });
        const double c =
            seconds_of([&] { converged = bool(model.run(study.model, study.parameters, *workspace)) && converged; });
        if (!definite || !converged) {
            fmt::print(stderr, "the study's own values have no answer\n");
            return 1;
        }
        if (round >= 0) {
            factorization.push_back(a);
            forward.push_back(b);
            jacobian.push_back(c);
        }
    }
    const double unit = median(factorization);
    const auto row = [&](const std::string& what, double seconds) {
        fmt::print("  {:<44} {:>9.3f} ms {:>8.1f} factorisations\n", what, 1e3 * seconds, seconds / unit);
    };
    const auto outcome = model.run(study.model, {}, *workspace);
    fmt::print("{}: {} unknowns, {} factorisations on the load path, medians of {} rounds\n", study.title,
               parts.model.free_unknowns(), outcome->statistics.factorizations, rounds);
    row("one sparse Cholesky factorisation", unit);
    row("forward run", median(forward));
    row(fmt::format("forward run with {} derivatives", study.parameters.size()), median(jacobian));
    fmt::print("  {:<44} {:>9.2f}\n", "with derivatives / without", median(jacobian) / median(forward));
    return 0;
}
