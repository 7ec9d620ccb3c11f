// The inputs of the runs of a batch, ready for the kernels. Private to fe/.
#pragma once

#include "fe/batch_solver.h"
#include "fe/lanes/layout.h"

namespace pave::fe::lanes {

class Inputs {
public:
    using Element = AxisymmetricQ8;

    Inputs(const Model<Element>& model, const Kernels& kernels);

    // As many runs as there are lanes, or fewer: the first one fills what is left.
    void prepare(std::span<const BatchRun> some, const std::vector<Variation>& by);
    void move(const Model<Element>& to);

    std::size_t layers() const { return runs[0].layers->size(); }
    std::size_t count() const { return variations->size(); }
    std::size_t rows() const { return layout.inverse.size(); }
    std::size_t points() const { return active.size() * Element::gauss; }
    const LayerMaterial& layer(std::size_t lane, std::size_t l) const { return (*runs[lane].layers)[l]; }
    bool is_linear(std::size_t l) const { return !layer(0, l).law->stress_dependent(); }
    // Of the stress-dependent elements.
    Points points_of_path() const;
    std::size_t bytes() const;

    const Model<Element>* model;
    const Kernels& kernels;
    std::size_t width;
    Layout layout;
    Structure structure;
    std::vector<double> shapes;
    Elements mesh;

    // The runs that go together, each repeated until the lanes are full.
    std::vector<BatchRun> runs;
    const std::vector<Variation>* variations = nullptr;
    std::vector<int> active;                // stress-dependent elements
    std::vector<std::vector<int>> of_layer; // elements of each linear layer; none of others
    std::vector<std::size_t> active_number; // of every element
    bool whole = false;                     // rates of all unknowns are followed, not only of those that change

    // Of every layer.
    Buffer unit, compliance, modulus, unit_rate, modulus_rate, law_numbers;
    std::vector<Modulus> laws;
    std::vector<Explicit> explicit_by;
    std::unique_ptr<bool[]> unit_varies;
    // Of every point of the active elements.
    Buffer initial, initial_rate, modulus_at, modulus_rate_at;

    Buffer load; // rows in the order of elimination

private:
    void prepare_layers();
    void prepare_layer(std::size_t l, std::size_t lane);
    void prepare_points();
    void set_stiffness(Buffer& buffer, std::size_t which, std::size_t lane, const mechanics::Stiffness<4>& c) const;
    static void ask_law(const void* context, int l, int lane, double theta, double tau, ModulusOfLane* result,
                        double* by_variation);
};

} // namespace pave::fe::lanes
