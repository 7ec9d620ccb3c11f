#include "data/fwd.h"

#include "data/csv.h"
#include "data/fwd_csv.h"
#include "data/fwd_f25.h"
#include "data/fwd_ltpp.h"
#include "data/fwd_pddx.h"

namespace explore::data {

std::span<const FwdFormat> fwd_formats() {
    static constexpr FwdFormat all[] = {
        fwd_csv,
        fwd_f25,
        fwd_pddx,
        fwd_ltpp,
    };
    return all;
}

std::vector<FwdStation> read_fwd(const std::string& file) {
    const std::string text = read_file(file, "FWD file", Encoding::utf8_or_latin1);
    std::string signs;
    for (const FwdFormat& format : fwd_formats()) {
        if (format.recognises(text)) {
            return format.read(text, file);
        }
        signs += (signs.empty() ? "" : "; ") + std::string(format.name) + ": " + std::string(format.sign);
    }
    throw pave::Error({.file = file}, "this is not an FWD file of a known format", {}, signs);
}

} // namespace explore::data
