#include "analysis/common/limit_words.h"

#include "base/error.h"

#include <fmt/format.h>

namespace explore::analysis {

std::string limit_words(const study::Study& study) {
    std::vector<std::string> limits;
    for (const data::Reading& m : study.measured()) {
        if (m.censored != data::Censored::no) {
            limits.push_back(fmt::format("{} {} {:g} {}", m.label(), data::sign_of(m.censored), m.value, m.unit.name));
        }
    }
    if (limits.empty()) {
        return "";
    }
    const bool one = limits.size() == 1;
    return fmt::format("{} ({}): {} to chi2 what {} probability says (-2 ln of it, from 0 where the model keeps {} and "
                       "1.4 on {}), and no degree of freedom.",
                       one ? "One reading is a limit" : fmt::format("{} readings are limits", limits.size()),
                       pave::join(limits), one ? "it adds" : "they add", one ? "its" : "their", one ? "it" : "them",
                       one ? "it" : "them");
}

} // namespace explore::analysis
