// A file of a falling weight deflectometer, whatever its format, and the bowls of its stations. The tables of LTPP that
// stand beside one another come in one input, each after a line that begins with a form feed.
#include "data/fwd.h"
#include "data/bowl_indices.h"
#include "target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const fuzz::Folder folder;
    std::string_view text = fuzz::text_of(data, size);
    std::string file;
    for (const char* table : {"DROP_DATA", "LOC_INFO", "DEV_CONFIG", "DEV_SENSORS"}) {
        const std::size_t end = std::min(text.find('\f'), text.size());
        const std::string written = folder.write(std::string("MON_DEFL_") + table + ".csv", text.substr(0, end));
        file = file.empty() ? written : file;
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    fuzz::expect_message([&] {
        for (const auto& station : explore::data::read_fwd(file).stations) {
            if (const auto bowls = explore::data::bowls_of(station)) {
                explore::data::indices_of(bowls->bowl(), 700.0);
            }
        }
    });
    return 0;
}
