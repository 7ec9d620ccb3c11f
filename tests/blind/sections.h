// Sections and readings as the generator of blind cases draws them, and what sections answer.
#pragma once

#include "base/random.h"
#include "pavement/section.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace blind {

using namespace pave;
using namespace pave::pavement;
using Eigen::VectorXd;
using Json = nlohmann::ordered_json;

class Draw {
public:
    Draw(std::uint64_t seed, std::uint64_t stream) : random_(seed, stream) {}
    double uniform(double low, double high) { return low + (high - low) * random_.uniform(next_++); }
    double log_uniform(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }
    std::size_t below(std::size_t n) {
        return std::min(n - 1, static_cast<std::size_t>(uniform(0.0, 1.0) * static_cast<double>(n)));
    }
    bool chance(double p) { return uniform(0.0, 1.0) < p; }
    double normal() { return random_.normal(1'000'000 + normal_++); }

private:
    RandomStream random_;
    std::uint64_t next_ = 0;
    std::uint64_t normal_ = 0;
};

Case draw_case(Draw& draw);
// The deflections of the plate and, under the wheel, the strains at the three upper depths.
void keep_few(Case& c);
// The deflections of the plate and so many others that 20 to 40 are left, drawn evenly.
void keep_middle(Case& c, Draw& draw);
// Puts the deflections of every load that has any at the places of one layout; the same case as the file states it.
Case lay_out(Case& c, Draw& draw, Json& truth);
// What else could be read: under both loads and under a drop that is half as heavy again; the strains of the study once
// more, by other gauges.
Case with_further_readings(Case c);
// Standard deviations that are common: of a deflection 2 % and 2 um, a strain 5 % and 10 microstrain, a stress 10 % and
// 2 kPa.
double common_noise(Quantity quantity, double value);
// Where neighbouring readings share their errors, their differences are known to a third of one reading's: the mesh
// must be right to that.
double study_refine(bool correlated);
Case finer(Case c);
// Responses; empty: none.
VectorXd responses(const Case& c);

} // namespace blind
