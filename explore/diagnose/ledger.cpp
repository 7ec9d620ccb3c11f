#include "diagnose/ledger.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace explore::diagnose {

double Ledger::chance(const std::string& key) const {
    double p = 1.0;
    bool is_known = false;
    for (const Chance& own : chances_) {
        if (own.key == key) {
            p = std::min(p, own.p);
            is_known = true;
        }
    }
    return is_known ? p : 0.0;
}

Says Ledger::says(const std::string& key) const {
    Says says = Says::nothing;
    for (const Located& own : located_) {
        says = own.key == key ? std::max(says, own.says) : says;
    }
    return says;
}

double Ledger::rate(const std::string& a, const std::string& b) const {
    double rate = 1.0;
    for (const Confounded& own : confounded_) {
        if ((own.a == a && own.b == b) || (own.a == b && own.b == a)) {
            rate = std::min(rate, own.rate);
        }
    }
    return rate;
}

bool Ledger::is_predicted_worse(const std::string& key) const {
    const double clearly = std::log(1.05);
    double growth = 0.0;
    double of_study = 0.0;
    for (const Predicted& own : predicted_) {
        if (own.key == key) {
            (own.by_study ? of_study : growth) += std::log(own.after / own.before);
        }
    }
    return growth > clearly || of_study > clearly;
}

double Ledger::beyond(const std::string& key, const std::vector<std::string>& subjects) const {
    double p = 1.0;
    for (const Beyond& own : beyond_) {
        if (own.key == key && std::find(subjects.begin(), subjects.end(), own.subject) == subjects.end()) {
            p = std::min(p, own.p);
        }
    }
    return p;
}

std::vector<std::size_t> rows_that_count(const Ledger& ledger) {
    std::map<std::string, std::size_t> best;
    for (std::size_t r = 0; r < ledger.rows().size(); ++r) {
        const Row& own = ledger.rows()[r];
        const auto [at, is_new] = best.try_emplace(own.hypothesis.key(), r);
        const Row& known = ledger.rows()[at->second];
        const auto rank = [](const Row& row) {
            return std::tuple(!row.not_tried.empty(), row.fit.mesh != Mesh::study, -row.order, row.fit.chi2,
                              -row.log_evidence);
        };
        if (!is_new && rank(own) < rank(known)) {
            at->second = r;
        }
    }
    std::vector<std::size_t> rows;
    rows.reserve(best.size());
    for (const auto& [key, r] : best) {
        rows.push_back(r);
    }
    return rows;
}

} // namespace explore::diagnose
