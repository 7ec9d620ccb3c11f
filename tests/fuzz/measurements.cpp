// A file of measurements.
#include "data/csv.h"
#include "data/reading.h"
#include "target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const fuzz::Folder folder;
    const std::string file = folder.write("measurements.csv", fuzz::text_of(data, size));
    fuzz::expect_message(
        [&] { explore::data::measurements_of(explore::data::read_file(file, "measurement file"), file); });
    return 0;
}
