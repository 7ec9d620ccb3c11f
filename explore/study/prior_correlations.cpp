#include "study/prior_correlations.h"

#include "base/error.h"
#include "study/table_reader.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

namespace explore::study {

void read_prior_correlations(const std::vector<const toml::table*>& tables, Study& study) {
    std::vector<std::string> known;
    for (const problem::Axis& axis : study.space.axes) {
        if (axis.prior) {
            known.push_back(axis.name);
        }
    }
    const auto n = static_cast<Eigen::Index>(known.size());
    Eigen::MatrixXd all = Eigen::MatrixXd::Identity(n, n);
    for (const toml::table* table : tables) {
        TableReader reader(*table, study.file, "[[prior_correlations]]");
        const std::vector<std::string> between = reader.texts(keys::correlation_between);
        const pave::Place place = reader.place(keys::correlation_between);
        if (between.size() != 2 || between[0] == between[1]) {
            throw pave::Error(place, "a correlation is between two parameters", pave::join(between),
                              std::string(keys::correlation_between.allowed));
        }
        Eigen::Index at[2] = {0, 0};
        for (std::size_t i = 0; i < 2; ++i) {
            const auto found = std::find(known.begin(), known.end(), between[i]);
            if (found == known.end()) {
                throw pave::Error(place, "this is no parameter with a prior", "\"" + between[i] + "\"",
                                  known.empty() ? "parameters with prior = { mean = ..., sd = ... }"
                                                : pave::join(known));
            }
            at[i] = found - known.begin();
        }
        if (all(at[0], at[1]) != 0.0) {
            throw pave::Error(place, "this pair of priors is given twice", pave::join(between), "each pair once");
        }
        const double value = reader.number(keys::correlation_value);
        reader.done();
        all(at[0], at[1]) = all(at[1], at[0]) = value;
        study.space.prior_correlations.push_back({.a = between[0], .b = between[1], .value = value});
        constexpr double least = 1e-6; // of a matrix that its Cholesky factor still describes
        if (Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(all).eigenvalues()[0] < least) {
            throw pave::Error(
                reader.place(keys::correlation_value),
                "these correlations of priors cannot hold together: their matrix is not positive definite",
                fmt::format("{:g} between {}", value, pave::join(between)), "smaller ones");
        }
    }
}

} // namespace explore::study
