// A study of linear layers on a half-space, whose forward runs take no time.
#pragma once

#include "study/study.h"

#include <fmt/format.h>

namespace test {

// readings: rows of a measurement file without its header. more: what follows the parameters of the moduli.
inline explore::study::Study layered_study(const std::string& readings, const std::string& more = "") {
    const std::string layers =
        "schema = 1\n[section]\nbottom = \"half-space\"\n"
        "[[layers]]\nname = \"asphalt\"\nthickness_mm = 150\ndensity_kg_m3 = 2300\nk0 = 0.5\nlaw = \"linear\"\n"
        "modulus_MPa = 3500\npoisson = 0.35\n"
        "[[layers]]\nname = \"base\"\nthickness_mm = 350\ndensity_kg_m3 = 2100\nk0 = 0.5\nlaw = \"linear\"\n"
        "modulus_MPa = 320\npoisson = 0.35\n"
        "[[layers]]\nname = \"subgrade\"\ndensity_kg_m3 = 1900\nk0 = 0.5\nlaw = \"linear\"\n"
        "modulus_MPa = 80\npoisson = 0.4\n"
        "[[loads]]\nname = \"fwd\"\ntype = \"plate\"\nradius_mm = 150\npressure_kPa = 650\n"
        "[[loads]]\nname = \"wheel\"\ntype = \"plate\"\nradius_mm = 110\npressure_kPa = 800\n"
        "[data]\nfiles = [\"bowl.csv\"]\nmisfit = \"weighted\"\n";
    std::string parameters;
    for (const auto& [name, low, high] :
         {std::tuple{"asphalt", 800, 15000}, {"base", 60, 1600}, {"subgrade", 20, 320}}) {
        parameters += fmt::format("[[parameters]]\nname = \"{}.modulus_MPa\"\nmin = {}\nmax = {}\nscale = \"log\"\n",
                                  name, low, high);
    }
    return explore::study::study_of(
        layers + parameters + more, "layered.toml",
        {{"bowl.csv", "load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\n" + readings}});
}

// Deflections that those layers have to about three digits, with an error of 2 %.
inline std::string layered_bowl() {
    return "fwd,deflection,0,0,0,0,0.4308,mm,0.0086\nfwd,deflection,200,0,0,0,0.3610,mm,0.0072\n"
           "fwd,deflection,300,0,0,0,0.3196,mm,0.0064\nfwd,deflection,600,0,0,0,0.2296,mm,0.0046\n"
           "fwd,deflection,900,0,0,0,0.1733,mm,0.0035\nfwd,deflection,1500,0,0,0,0.1093,mm,0.0022\n";
}

} // namespace test
