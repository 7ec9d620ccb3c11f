#include "diagnose/candidate_fits.h"

#include <algorithm>
#include <cmath>

namespace explore::diagnose {

std::optional<Model> CandidateFits::lower(const Members& members, int number, const std::vector<double>& start,
                                          const Shift& shift, const std::optional<Model>& found, double worth,
                                          bool is_proposal) const {
    constexpr double lower = 0.1; // chi2
    FitSettings settings = is_proposal ? for_residuals(nullptr, variance_) : FitSettings{};
    settings.worth = found ? std::min(worth, found->sum - lower * variance_) : worth;
    settings.on_coarse = &shift;
    return fit_from(bench_, members, number, start, variance_, {}, settings);
}

std::optional<Model> CandidateFits::added(const Model& base, const Model* other, const Screened& screened,
                                          std::size_t candidate, int number, double worth, bool is_proposal) const {
    const Members members = with_member(base.members, candidate);
    std::vector<std::vector<double>> starts;
    const auto propose = [&](std::size_t i) {
        if (i < screened.starts.size()) {
            starts.push_back(screened.starts[i].unit);
        }
    };
    const std::size_t at = size_index(bench_, members, candidate);
    propose(0);
    starts.push_back(with_size(base.unit, at, candidates_[candidate].null));
    propose(1);
    if (other != nullptr) {
        starts.push_back(with_size(other->unit, at, candidates_[candidate].typical));
    }
    std::optional<Model> best;
    for (std::size_t s = 0; s < starts.size() && !reaches(best, screened); ++s) {
        keep_lower(best,
                   lower(members, number + static_cast<int>(s), starts[s], screened.shift, best, worth, is_proposal));
    }
    return best;
}

bool CandidateFits::reaches(const std::optional<Model>& found, const Screened& screened) const {
    constexpr double near = 4.0; // chi2
    return found && found->sum < screened.predicted + near * variance_;
}

std::optional<Model> CandidateFits::confirm(const std::optional<Model>& found, int number, double worth) const {
    return found ? fit_from(bench_, found->members, number, found->unit, variance_, {}, {.worth = worth})
                 : std::nullopt;
}

double CandidateFits::worth_confirming(double worth) const {
    constexpr double error = 2.0; // chi2
    return worth + error * variance_;
}

std::optional<Model> CandidateFits::from_all_sides(const Model& base, const Screened& screened, std::size_t candidate,
                                                   int number, std::optional<Model> found, double worth,
                                                   bool is_proposal) const {
    const Members members = with_member(base.members, candidate);
    const std::size_t at = size_index(bench_, members, candidate);
    const Candidate& added = candidates_[candidate];
    constexpr double large = 0.6; // of the way to the end of the range
    int start = number;
    for (const double size : {added.typical, 2.0 * added.null - added.typical, added.null + large * (1.0 - added.null),
                              (1.0 - large) * added.null}) {
        if (size > 0.0 && size < 1.0 && std::abs(size - added.null) > 1e-3) {
            keep_lower(found, lower(members, start, with_size(base.unit, at, size), screened.shift, found, worth,
                                    is_proposal));
        }
        ++start;
    }
    return found;
}

std::optional<Model> CandidateFits::blindly(const Model& base, const Screening& screening, std::size_t candidate,
                                            int number, double worth) const {
    return confirm(
        from_all_sides(base, screening.items[candidate], candidate, number, {}, worth_confirming(worth), true), number,
        worth);
}

} // namespace explore::diagnose
