// The mesh's error in an answer: one run at its parameters on a finer mesh.
#pragma once

#include "study/problems.h"

#include <optional>

namespace explore::analysis {

struct MeshError {
    struct Moved {
        std::string parameter;
        double standard_errors = 0.0; // that it moves by; 0 on a bound and where it is not determined
    };
    double refine = 0.0;      // of the finer mesh
    double beyond = 0.0;      // norm of the change of the residuals that no parameter can absorb, in standard
                              // deviations of the noise
    double chi2 = 0.0;        // of the answer
    double chi2_finer = 0.0;  // of the fit on the finer mesh, to first order
    std::vector<Moved> moved; // every parameter, to first order
    std::size_t reading = 0;  // of the study: the one that changes most in standard deviations
    double change = 0.0;      // relative change of that reading
    struct Output {
        std::size_t reading = 0; // of the study
        double change = 0.0;     // relative change by the error of the mesh
        double deviations = 0.0; // the same in the standard deviations that the noise leaves
    };
    std::vector<Output> outputs{}; // set by callers that know the outputs
    bool shows() const;            // beside the noise
};

// The study on a mesh 1.5 times as fine; nothing: a run there would take more than 0.5 GB (wheels in three dimensions
// on large meshes), or the mesh is too large.
std::optional<study::Study> on_finer_mesh(const study::Study& study);

// On a mesh half as fine and with longer steps of load, in a run of its own: quicker, and off by a few per cent.
study::Study on_coarser_mesh(study::Study study);

// study: whose problem it is, with its effects; answer: with jacobian, at `unit`. noise: standard deviation of a
// residual. Nothing: no mesh computes the readings, or there is no finer one or no answer on it.
std::optional<MeshError> mesh_error(const study::Study& study, const problem::Problem& problem,
                                    const problem::Evaluation& answer, const std::vector<double>& unit, double noise);

// The error in a sentence, where it shows; else "".
std::string mesh_words(const study::Study& study, const std::optional<MeshError>& error);

} // namespace explore::analysis
