// Fits of models with one candidate more: proposed on the coarse mesh, confirmed on the study's own.
#pragma once

#include "diagnose/screening.h"

namespace explore::diagnose {

// worth, wherever it is given: a sum of squares; nothing, where none gets as low. number: of the first evaluation that
// is kept, of a few on each mesh.
class CandidateFits {
public:
    // variance: of a residual, as it is when a fit is requested. All three have to outlive this.
    CandidateFits(Workbench& bench, const std::vector<Candidate>& candidates, const double& variance)
        : bench_(bench),
          candidates_(candidates),
          variance_(variance) {}

    // On the coarse mesh, from a point; it is to get lower than what is found so far, too. is_proposal: what it finds
    // is fitted again, and needs no derivatives.
    std::optional<Model> lower(const Members& members, int number, const std::vector<double>& start, const Shift& shift,
                               const std::optional<Model>& found, double worth, bool is_proposal) const;
    // On the coarse mesh, base with one candidate more: from the starts that the screening proposes, until one gets as
    // low as predicted. other: a further minimum of the base, or nullptr.
    std::optional<Model> added(const Model& base, const Model* other, const Screened& screened, std::size_t candidate,
                               int number, double worth, bool is_proposal) const;
    // Whether a fit gets about as low as the screening promises.
    bool reaches(const std::optional<Model>& found, const Screened& screened) const;
    // Results of the coarse mesh, on the study's own.
    std::optional<Model> confirm(const std::optional<Model>& found, int number, double worth = INFINITY) const;
    // The limit below which a fit on the coarse mesh is worth one on the study's own: it errs by less.
    double worth_confirming(double worth) const;
    // On the coarse mesh, base with one candidate more, whatever the screening says of it: from a typical size on both
    // sides of none, and from large ones; the lowest of them and of what was found before.
    std::optional<Model> from_all_sides(const Model& base, const Screened& screened, std::size_t candidate, int number,
                                        std::optional<Model> found, double worth, bool is_proposal) const;
    // That and then on the study's own.
    std::optional<Model> blindly(const Model& base, const Screening& screening, std::size_t candidate, int number,
                                 double worth) const;

private:
    Workbench& bench_;
    const std::vector<Candidate>& candidates_;
    const double& variance_;
};

} // namespace explore::diagnose
