// A table with names of its own: the first line of the input is the list of columns, the rest the table.
#include "data/deflection_bowl.h"
#include "data/fwd.h"
#include "target.h"

#include <algorithm>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const fuzz::Folder folder;
    std::string_view text = fuzz::text_of(data, size);
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string list(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    const std::string table = folder.write("table.csv", text);
    if (list.find('=') != std::string::npos) { // else it is the name of a file
        fuzz::expect_message([&] { explore::data::read_column_map(list); }, "--columns");
    }
    std::replace(list.begin(), list.end(), ',', '\n');
    const std::string file = folder.write("columns.txt", list);
    const auto read = [&] {
        for (const auto& fwd : explore::data::read_fwd_files({table}, file)) {
            for (const auto& station : fwd.stations) {
                explore::data::bowls_of(station);
            }
        }
    };
    fuzz::expect_message(read, "--columns");
    return 0;
}
