// A study file: read, and made into all that a command makes of it before it computes.
#include "study/problems.h"
#include "target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const fuzz::Folder folder;
    static const std::string measurements = folder.write(
        "small.csv", "load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\nfwd,deflection,0,0,0,0,0.95,mm,\n"
                     "fwd,deflection,300,0,0,0,520,um,10\nfwd,strain_zz,0,0,180,75,0.0008,strain,\n");
    const std::string file = folder.write("study.toml", fuzz::text_of(data, size));
    fuzz::expect_message([&] {
        const auto study = explore::study::load_study(file, explore::study::Readings::own);
        if (!study.measured().empty() && !study.parameters.empty()) {
            explore::study::make_noise_problem(study, explore::study::Scope::fitted);
        }
    });
    fuzz::expect_message([&] { explore::study::load_study(file, explore::study::Readings::elsewhere); });
    return 0;
}
