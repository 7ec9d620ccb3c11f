// The worth of a fit: its posterior, other models, what the model lacks, what it means for life.
#include "analyses.h"

#include "call.h"
#include "report/compare.h"
#include "report/design.h"
#include "report/diagnose.h"
#include "report/predictive.h"
#include "report/sample.h"

#include <pybind11/eigen.h>
#include <pybind11/stl.h>

namespace python {
namespace {

namespace analysis = explore::analysis;
namespace report = explore::report;
using Eigen::Index;

// The draws beside the JSON: parameters, outputs (file units; not a number: not computed), weights.
py::tuple sample(const Study& study, const py::object& samples, const py::object& confirm, const std::string& model,
                 const std::string& out, const py::object& threads, const py::object& seed,
                 const py::object& model_error, const py::object& time) {
    analysis::SampleOptions options{.any_model = model.empty(),
                                    .samples = whole(samples, "samples", allowed::sample_draws),
                                    .confirm = whole(confirm, "confirm", allowed::sample_confirm)};
    options.model = model_of(model.empty() ? "full" : model, model_error);
    Eigen::MatrixXd parameters;
    Eigen::MatrixXd outputs;
    Eigen::VectorXd weights;
    std::string json = analysed(run_options(out, threads, seed), "sample",
                                [&](auto& session) {
                                    auto result = analysis::sample(session, study.study(), options);
                                    if (result) {
                                        const auto n = static_cast<Index>(result->draws.size());
                                        const auto wanted = study.study().outputs();
                                        parameters.resize(n, study.study().space.dimension());
                                        outputs = Eigen::MatrixXd::Constant(n, static_cast<Index>(wanted.size()), NAN);
                                        weights = array(result->descent.weight);
                                        for (Index i = 0; i < n; ++i) {
                                            const auto& draw = result->draws[static_cast<std::size_t>(i)];
                                            parameters.row(i) = array(draw.parameters);
                                            for (std::size_t o = 0; o < draw.outputs.size(); ++o) {
                                                outputs(i, static_cast<Index>(o)) =
                                                    study.study().readings[wanted[o]].in_unit(draw.outputs[o]);
                                            }
                                        }
                                    }
                                    return result;
                                },
                                report::sample_json, {time_of(time), &study.study()});
    return py::make_tuple(json, parameters, outputs, weights);
}

std::string prior_check(const Study& study, const py::object& samples, const std::string& out,
                        const py::object& threads, const py::object& seed, const py::object& time) {
    const int points = whole(samples, "samples", allowed::sample_draws);
    return analysed(run_options(out, threads, seed), "sample-prior",
                    [&](auto& session) { return analysis::prior_check(session, study.study(), points); },
                    report::prior_check_json, {time_of(time), &study.study()});
}

std::string diagnose(const Study& study, const py::object& explore, const py::object& starts,
                     const py::object& bootstrap, const std::vector<std::string>& without, const std::string& model,
                     const std::string& out, const py::object& threads, const py::object& seed,
                     const py::object& model_error, const py::object& time) {
    one_of(model, std::vector<std::string>{"full", "auto"}, "model"); // effects change what a reduced one is made for
    analysis::DiagnoseOptions options{.model = model_of(model, model_error), .without = without, .settings = {}};
    options.settings.explore = whole(explore, "explore", allowed::diagnose_explore);
    options.settings.starts = whole(starts, "starts", allowed::diagnose_starts);
    options.settings.bootstrap = whole(bootstrap, "bootstrap", allowed::diagnose_bootstrap);
    return analysed(run_options(out, threads, seed), "diagnose",
                    [&](auto& session) {
                        auto result = analysis::diagnose(session, study.study(), options);
                        if (result && result->is_extended() && !out.empty()) {
                            report::write_extended(*result, session.options());
                        }
                        return result;
                    },
                    report::diagnose_json, {time_of(time), &study.study()});
}

std::string compare(const Study& study, const std::vector<const Study*>& others, const std::string& layer,
                    const std::vector<std::string>& laws, const py::object& explore, const py::object& verify,
                    const std::string& out, const py::object& threads, const py::object& seed, bool evidence) {
    if (!others.empty() && (!layer.empty() || !laws.empty())) {
        throw py::value_error("layer and laws: laws of one study are compared, or other studies with it; allowed: one "
                              "of the two");
    }
    analysis::CompareOptions options{.layer = layer, .laws = laws};
    options.settings.explore = whole(explore, "explore", allowed::compare_explore);
    options.settings.verify = whole(verify, "verify", allowed::compare_verify);
    options.evidence = evidence;
    return analysed(
        run_options(out, threads, seed), "compare",
        [&](auto& session) {
            if (others.empty()) {
                return analysis::compare(session, study.study(), options);
            }
            std::vector<explore::study::Study> studies{study.study()};
            for (const Study* other : others) {
                studies.push_back(other->study());
            }
            return analysis::compare_studies(session, studies, options);
        },
        report::compare_json);
}

std::string design(const Study& study, const py::object& reliability, const py::object& years,
                   const py::object& explore, const py::object& verify, const std::string& model,
                   const std::string& out, const py::object& threads, const py::object& seed,
                   const py::object& model_error) {
    one_of(model, std::vector<std::string>{"full", "auto"}, "model"); // ends of ranges are the full model's
    analysis::DesignOptions options;
    options.settings.explore = whole(explore, "explore", allowed::unique_explore);
    options.settings.verify = whole(verify, "verify", allowed::unique_verify);
    options.model = model_of(model, model_error);
    options.reliability_percent = real(reliability, "reliability", allowed::design_reliability);
    options.years = real(years, "years", allowed::design_years);
    return analysed(
        run_options(out, threads, seed), "design",
        [&](auto& session) { return analysis::design(session, study.study(), options); }, report::design_json);
}

} // namespace

void add_judgements(py::class_<Study>& study) {
    study
        .def("sample", &sample, py::arg("samples"), py::arg("confirm"), py::arg("model"), py::arg("out"),
             py::arg("threads"), py::arg("seed"), py::arg("model_error"), py::arg("time"))
        .def("prior_check", &prior_check, py::arg("samples"), py::arg("out"), py::arg("threads"), py::arg("seed"),
             py::arg("time"))
        .def("diagnose", &diagnose, py::arg("explore"), py::arg("starts"), py::arg("bootstrap"), py::arg("without"),
             py::arg("model"), py::arg("out"), py::arg("threads"), py::arg("seed"), py::arg("model_error"),
             py::arg("time"))
        .def("compare", &compare, py::arg("others"), py::arg("layer"), py::arg("laws"), py::arg("explore"),
             py::arg("verify"), py::arg("out"), py::arg("threads"), py::arg("seed"), py::arg("evidence"))
        .def("design", &design, py::arg("reliability"), py::arg("years"), py::arg("explore"), py::arg("verify"),
             py::arg("model"), py::arg("out"), py::arg("threads"), py::arg("seed"), py::arg("model_error"));
}

} // namespace python
