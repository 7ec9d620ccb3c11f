// Models that are not ours: templates, readings in files, noise and differences, a child process.
#include "base/error.h"
#include "external/child.h"
#include "external/differences.h"
#include "external/outputs.h"
#include "external/template.h"
#include "run/files.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <gtest/gtest.h>

using namespace explore::external;

namespace {

const std::vector<std::string> names{"k1", "base.n"};

std::string filled(const std::string& text, std::vector<double> values) {
    const auto outcome = Template(text, "job.in", names).filled(values);
    return outcome ? *outcome : "(" + std::string(to_string(outcome.status())) + ") " + outcome.failure().reason;
}

std::string complaint_of(const std::string& text) {
    try {
        Template(text, "job.in", names);
    } catch (const pave::Error& error) {
        return error.what();
    }
    return "none";
}

Wanted reading(const std::string& label, double x_mm, const std::string& output = "") {
    return {.label = label, .load = "fwd", .quantity = "deflection", .x_mm = x_mm, .output = output};
}

struct Folder {
    explore::run::TemporaryFolder folder;
    void write(const std::string& name, const std::string& text) {
        explore::run::write_file(folder.path(), name, text);
    }
    std::string read(const std::vector<OutputFile>& outputs, const std::vector<Wanted>& wanted,
                     std::vector<double>* values = nullptr) {
        const auto outcome = read_outputs(outputs, wanted, folder.path());
        if (outcome && values != nullptr) {
            *values = *outcome;
        }
        return outcome ? "read" : outcome.failure().reason;
    }
};

} // namespace

TEST(Template, FillsPlacesInFormats) {
    EXPECT_EQ(filled("a {{k1}} b {{base.n:%8.3f}}|{{k1:%12.5e}}|\n", {0.1, -2.0}), "a 0.1 b   -2.000| 1.00000e-01|\n");
    EXPECT_EQ(filled("{{k1:%-10.2E}}|{{k1:%g}}", {1500.0, 0.0}), "1.50E+03  |1500");
    EXPECT_EQ(filled("no place {k1}", {1.0, 2.0}), "no place {k1}");
    EXPECT_TRUE(Template("{{k1}}", "f", names).uses(0));
    EXPECT_FALSE(Template("{{k1}}", "f", names).uses(1));
}

TEST(Template, ShortestNumbersReadBackTheSame) {
    for (const double value : {0.1, 1.0 / 3.0, 6.02e23, 5e-324, 123456789.0}) {
        EXPECT_EQ(std::strtod(filled("{{k1}}", {value, 0.0}).c_str(), nullptr), value);
    }
}

TEST(Template, AValueWiderThanItsColumnsIsNoAnswer) {
    const std::string wide = filled("{{k1:%6.1f}}", {123456.0, 0.0});
    EXPECT_NE(wide.find("invalid-parameters"), std::string::npos) << wide;
    EXPECT_NE(wide.find("k1 = 123456.0 does not fit the 6 columns"), std::string::npos) << wide;
    EXPECT_EQ(filled("{{k1:%8.1f}}", {123456.0, 0.0}), "123456.0");
    EXPECT_NE(filled("{{k1:%10.3e}}", {-1e-100, 0.0}).find("does not fit"), std::string::npos); // -1.000e-100
}

TEST(Template, ComplainsOfBadPlaces) {
    const std::string unknown = complaint_of("x\n{{k2}}\n");
    EXPECT_NE(unknown.find("job.in:2"), std::string::npos) << unknown;
    EXPECT_NE(unknown.find("did you mean \"k1\""), std::string::npos) << unknown;
    EXPECT_NE(complaint_of("{{k1").find("not closed"), std::string::npos);
    EXPECT_NE(complaint_of("{{k1\n}}").find("not closed"), std::string::npos);
    for (const char* format : {"%s", "%d", "%n", "%5.2f%f", "5.2f", "%", "%5.2", "%999f", "%*f", "%lf"}) {
        EXPECT_NE(complaint_of(std::string("{{k1:") + format + "}}").find("no format of a number"), std::string::npos)
            << format;
    }
}

TEST(OutputLine, IsSaidInWords) {
    EXPECT_EQ(line_of("12")->number, 12U);
    EXPECT_EQ(line_of("after 'strains'")->marker, "strains");
    EXPECT_EQ(line_of("after 'strains'")->number, 1U);
    EXPECT_EQ(line_of("3 after last 'it''s'")->marker, "it''s");
    EXPECT_TRUE(line_of("3 after last 'a'")->last);
    EXPECT_EQ(line_of("with 'f ='")->number, 0U);
    for (const char* wrong :
         {"", "0", "after", "after strains", "after ''", "before 'a'", "3 with 'a'", "-1", "3 'a'"}) {
        EXPECT_FALSE(line_of(wrong)) << wrong;
    }
}

TEST(Outputs, OfLinesAndColumns) {
    Folder f;
    f.write("job.dat", "step 1\nstrains\n 1  1.5D-04, 7\nstep 2\nstrains\r\n 2 +2.5E-04;8\r\nf = 3\n");
    const std::vector<Wanted> wanted{reading("a", 0), reading("b", 1), reading("c", 2), reading("d", 3)};
    const auto entry = [](std::size_t reading, const char* line, std::size_t column) {
        return OutputFile{.file = "job.dat", .reading = reading, .line = line_of(line), .column = column};
    };
    std::vector<double> values;
    EXPECT_EQ(f.read({entry(0, "after 'strains'", 2), entry(1, "after last 'strains'", 2), entry(2, "with 'f ='", 3),
                      entry(3, "3", 3)},
                     wanted, &values),
              "read");
    EXPECT_EQ(values, (std::vector<double>{1.5e-4, 2.5e-4, 3.0, 7.0}));
    const std::vector<Wanted> one{reading("a", 0)};
    EXPECT_EQ(f.read({entry(0, "after 'stress'", 2)}, one), "a is missing: no line of job.dat holds \"stress\"");
    EXPECT_EQ(f.read({entry(0, "after 'strains'", 9)}, one),
              "a is missing: line 3 of job.dat has 3 columns, and column 9 is wanted");
    EXPECT_EQ(f.read({entry(0, "5 after last 'strains'", 1)}, one),
              "a is missing: job.dat has 7 lines, and line 10 is wanted");
    EXPECT_EQ(f.read({entry(0, "2", 1)}, one), "a in job.dat is \"strains\", which is not a finite number");
    EXPECT_EQ(f.read({{.file = "none.dat", .reading = 0, .line = line_of("1")}}, one), "the program wrote no none.dat");
}

TEST(Outputs, OfTables) {
    Folder f;
    f.write("out.csv",
            "x_mm,load,value,quantity\n0.0,fwd,1.0,deflection\n300,fwd,2.0,deflection\n0,other,9,deflection\n"
            "300.0,fwd,2.5,deflection\n");
    const OutputFile table{.file = "out.csv", .by = {"load", "quantity", "x_mm"}, .value_column = "value"};
    std::vector<double> values;
    EXPECT_EQ(f.read({table}, {reading("a", 300), reading("b", 0)}, &values), "read");
    EXPECT_EQ(values, (std::vector<double>{2.5, 1.0})); // the later of two rows
    EXPECT_EQ(f.read({table}, {reading("a", 300), reading("b", 600)}), "b is missing in out.csv");
    f.write("out.csv", "x_mm,value\n300,nan\n");
    const OutputFile by_x{.file = "out.csv", .by = {"x_mm"}, .value_column = "value"};
    EXPECT_EQ(f.read({by_x}, {reading("a", 300)}), "a in out.csv is \"nan\", which is not a finite number");
    EXPECT_EQ(f.read({table}, {reading("a", 300)}), "out.csv has no column load");
    f.write("out.csv", "name,value\nlife,7\na,3\n");
    const OutputFile by_name{.file = "out.csv", .by = {"name"}, .value_column = "value"};
    EXPECT_EQ(f.read({by_name}, {reading("a", 0), reading("life", 0, "life")}, &values), "read");
    EXPECT_EQ(values, (std::vector<double>{3.0, 7.0}));
}

TEST(Outputs, OfJson) {
    Folder f;
    const std::vector<Wanted> two{reading("a", 0), reading("b", 1)};
    const OutputFile list{.file = "o.json", .at = "/r"};
    std::vector<double> values;
    f.write("o.json", R"({"r": [1, 2.5], "deep": {"x": 4}})");
    EXPECT_EQ(f.read({list}, two, &values), "read");
    EXPECT_EQ(values, (std::vector<double>{1.0, 2.5}));
    EXPECT_EQ(
        f.read({list, {.file = "o.json", .reading = 2, .at = "/deep/x"}}, {two[0], two[1], reading("c", 2)}, &values),
        "read");
    EXPECT_EQ(values, (std::vector<double>{1.0, 2.5, 4.0}));
    f.write("o.json", R"({"r": [1, 2, 3]})");
    EXPECT_EQ(f.read({list}, two), "/r of o.json is a list of 3, where a list of 2 readings is wanted");
    f.write("o.json", R"({"r": [1, null]})");
    EXPECT_EQ(f.read({list}, two), "b in o.json is null, which is not a finite number");
    f.write("o.json", R"({"r": {"b": 1}})");
    EXPECT_EQ(f.read({list}, two), "a is missing in o.json");
    f.write("o.json", R"({"s": 1})");
    EXPECT_EQ(f.read({list}, two), "o.json has nothing at /r");
    f.write("o.json", "{");
    EXPECT_EQ(f.read({list}, two), "o.json is not valid JSON");
}

TEST(Noise, OfRoundedNumbersIsThatOfTheirLastDigit) {
    // Uniform errors of a unit in the last place have a standard deviation of 1 / sqrt(12) of it.
    for (const double digit : {1e-3, 1e-5}) {
        std::vector<double> values;
        for (int i = 0; i <= 6; ++i) {
            values.push_back(digit * std::round(std::exp(1.0 + 37.31 * digit * i) / digit));
        }
        const auto noise = noise_of(values);
        ASSERT_TRUE(noise) << digit;
        EXPECT_GT(*noise, digit / std::sqrt(12.0) / 4.0);
        EXPECT_LT(*noise, digit / std::sqrt(12.0) * 4.0);
    }
    EXPECT_FALSE(noise_of({1, 1, 1, 1, 1, 2, 2})); // too near to be told apart
}

TEST(Differences, FollowTheNoise) {
    const auto responses = [](double digit, int& runs) {
        return [digit, &runs](const std::vector<double>& u) -> std::optional<std::vector<double>> {
            ++runs;
            std::vector<double> values{std::exp(u[0] + 0.5 * u[1]), std::sin(2.0 * u[0]) + u[1]};
            for (double& value : values) {
                value = digit > 0.0 ? digit * std::round(value / digit) : value;
            }
            return values;
        };
    };
    for (const double digit : {0.0, 1e-9, 1e-5}) {
        int runs = 0;
        const auto f = responses(digit, runs);
        const std::vector<double> at{0.3, 0.6};
        const Differences d = estimate_differences(f, at);
        EXPECT_EQ(d.runs, runs);
        EXPECT_GT(d.noise, 0.0);
        EXPECT_EQ(d.central, digit > 0.0) << d.words();
        const double exact = 2.0 * std::cos(0.6); // d(second)/d(u0)
        double slope = 0.0;
        const Stencil stencil = stencil_at(at[0], d, 0);
        const double here = (*f(at))[1];
        for (std::size_t s = 0; s < stencil.at.size(); ++s) {
            slope += stencil.weights[s] * ((*f({stencil.at[s], at[1]}))[1] - here);
        }
        EXPECT_NEAR(slope, exact, 1e-6 + 20.0 * std::pow(digit, 2.0 / 3.0)) << digit;
    }
}

// A model that reads its inputs with six digits, or three decimals, or writes five of a linear answer: at the middle of
// a box of round numbers all of these are exact. Slopes by hand.
TEST(Differences, SeeWhatAModelRoundsAway) {
    const auto printed = [](const char* format, double value) {
        char text[32];
        std::snprintf(text, sizeof text, format, value);
        return std::strtod(text, nullptr);
    };
    const std::pair<double, double> boxes[] = {{0, 1},     {0, 10},   {0, 100},     {0, 1000},     {0.5, 2},
                                               {0.2, 1.2}, {20, 120}, {1000, 2000}, {1000, 10000}, {-1, 1},
                                               {0, 3},     {10, 50},  {0.1, 1},     {1000, 5000}};
    for (const char* const format : {"%12.5e", "%.3f", "%.4f"}) {
        for (const auto& [low, high] : boxes) {
            const auto f = [&](const std::vector<double>& unit) -> std::optional<std::vector<double>> {
                const double u = (printed(format, low + unit[0] * (high - low)) - low) / (high - low);
                const double v = (printed(format, low + unit[1] * (high - low)) - low) / (high - low);
                return std::vector<double>{std::exp(-u) + 0.3 * v, std::exp(-2.0 * u) + v * v, 0.3 * u + v};
            };
            const std::vector<double> at{0.5, 0.5};
            const Differences d = estimate_differences(f, at);
            const double exact[2][3] = {{-std::exp(-0.5), -2.0 * std::exp(-1.0), 0.3}, {0.3, 1.0, 1.0}};
            const auto here = *f(at);
            for (std::size_t k = 0; k < 2; ++k) {
                const Stencil stencil = stencil_at(at[k], d, k);
                for (std::size_t i = 0; i < 3; ++i) {
                    double slope = 0.0;
                    for (std::size_t s = 0; s < stencil.at.size(); ++s) {
                        std::vector<double> point = at;
                        point[k] = stencil.at[s];
                        slope += stencil.weights[s] * ((*f(point))[i] - here[i]);
                    }
                    EXPECT_NEAR(slope, exact[k][i], 0.02 * std::abs(exact[k][i]))
                        << format << " in " << low << " to " << high << ": " << d.words();
                }
            }
        }
    }
    // Linear, with five decimals in what it writes.
    const auto line = [](const std::vector<double>& unit) -> std::optional<std::vector<double>> {
        return std::vector<double>{1e-5 * std::round(1e5 * (unit[0] + 2.0 * unit[1])),
                                   1e-5 * std::round(1e5 * unit[1])};
    };
    const Differences d = estimate_differences(line, {0.5, 0.5});
    EXPECT_GT(d.steps[0], 1e-4) << d.words();
}

TEST(Differences, StayInTheCube) {
    for (const bool central : {false, true}) {
        for (const double at : {0.0, 0.004, 0.5, 0.999, 1.0}) {
            const Differences d{.steps = {0.01}, .central = central};
            const Stencil stencil = stencil_at(at, d, 0);
            double line = 0.0;
            double parabola = 0.0;
            for (std::size_t s = 0; s < stencil.at.size(); ++s) {
                EXPECT_GE(stencil.at[s], 0.0);
                EXPECT_LE(stencil.at[s], 1.0);
                line += stencil.weights[s] * (stencil.at[s] - at);
                parabola += stencil.weights[s] * (stencil.at[s] * stencil.at[s] - at * at);
            }
            EXPECT_NEAR(line, 1.0, 1e-12);
            EXPECT_NEAR(parabola, 2.0 * at, central ? 1e-12 : 0.011);
        }
    }
}

TEST(Child, EndsAsItDoes) {
    const explore::run::TemporaryFolder folder;
    using Kind = ChildEnd::Kind;
    EXPECT_EQ(run_child({"true"}, folder.path(), 0.0).kind, Kind::exited);
    const ChildEnd failed = run_child({"sh", "-c", "exit 3"}, folder.path(), 10.0);
    EXPECT_EQ(failed.kind, Kind::exited);
    EXPECT_EQ(failed.code, 3);
    EXPECT_EQ(run_child({"sh", "-c", "kill -9 $$"}, folder.path(), 10.0).kind, Kind::killed);
    EXPECT_EQ(run_child({"sleep", "60"}, folder.path(), 0.2).kind, Kind::over_time);
    EXPECT_EQ(run_child({"/no/such/program"}, folder.path(), 0.0).kind, Kind::not_started);
}
