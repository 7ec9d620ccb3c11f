#include "report/figure_pair.h"

#include <algorithm>
#include <cmath>

namespace explore::report {
namespace {

std::vector<double> without_holes(std::vector<double> z, std::size_t nx) {
    const std::size_t ny = z.size() / nx;
    for (bool again = true; again;) {
        again = false;
        std::vector<double> filled = z;
        for (std::size_t n = 0; n < z.size(); ++n) {
            if (!std::isnan(z[n])) {
                continue;
            }
            double sum = 0.0;
            int count = 0;
            const std::size_t i = n % nx;
            const std::size_t j = n / nx;
            const auto take = [&](bool there, std::size_t other) {
                if (there && !std::isnan(z[other])) {
                    sum += z[other];
                    ++count;
                }
            };
            take(i > 0, n - 1);
            take(i + 1 < nx, n + 1);
            take(j > 0, n - nx);
            take(j + 1 < ny, n + nx);
            if (count > 0) {
                filled[n] = sum / count;
                again = true;
            }
        }
        z = std::move(filled);
    }
    return z;
}

} // namespace

bool Pair::has_answers() const {
    return std::any_of(grid.z.begin(), grid.z.end(), [](double z) { return !std::isnan(z); });
}

Pair pair_of(const Json& json, const std::vector<Parameter>& parameters) {
    Pair pair;
    pair.x = index_of(parameters, json.at("x"));
    pair.y = index_of(parameters, json.at("y"));
    const auto x = numbers_of(json.at("x_values"));
    const auto y = numbers_of(json.at("y_values"));
    pair.grid = {parameters[pair.x].units(x), parameters[pair.y].units(y), {}};
    for (std::size_t j = 0; j < y.size(); ++j) {
        for (std::size_t i = 0; i < x.size(); ++i) {
            pair.grid.z.push_back(number_or_none(json.at("rise").at(j).at(i)));
        }
    }
    return pair;
}

Grid fine_roots(const Grid& rises, int times) {
    Grid grid = rises;
    grid.z = without_holes(grid.z, grid.x.size());
    Grid fine = refined(grid, times);
    for (double& z : fine.z) {
        z = std::sqrt(std::max(0.0, z));
    }
    return fine;
}

} // namespace explore::report
