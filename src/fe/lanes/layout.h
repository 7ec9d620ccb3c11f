// The parts that all lanes share: the structure of the factor in tiles and the elements of a mesh, in the order of
// elimination. Private to fe/.
#pragma once

#include "fe/lanes/kernels.h"
#include "fe/model.h"

#include <cstdlib>
#include <memory>
#include <new>
#include <vector>

namespace pave::fe::lanes {

// Numbers of every lane, aligned for the kernels; zero at first.
class Buffer {
public:
    // count: of vectors. What was there is lost where it grows.
    void resize(std::size_t count, int width) {
        const std::size_t bytes =
            (count * static_cast<std::size_t>(width) * sizeof(double) + alignment - 1) / alignment * alignment;
        if (bytes > bytes_) {
            numbers_.reset(static_cast<double*>(std::aligned_alloc(alignment, bytes)));
            bytes_ = numbers_ ? bytes : 0;
            if (!numbers_) {
                throw std::bad_alloc();
            }
        }
        size_ = count * static_cast<std::size_t>(width);
    }
    void assign_zero(std::size_t count, int width) {
        resize(count, width);
        std::fill(data(), data() + size_, 0.0);
    }
    double* data() { return numbers_.get(); }
    const double* data() const { return numbers_.get(); }
    double& operator[](std::size_t i) { return numbers_.get()[i]; }
    double operator[](std::size_t i) const { return numbers_.get()[i]; }
    std::size_t size() const { return size_; }
    std::size_t bytes() const { return bytes_; }

private:
    struct Free {
        void operator()(double* numbers) const { std::free(numbers); }
    };
    std::unique_ptr<double, Free> numbers_;
    std::size_t bytes_ = 0;
    std::size_t size_ = 0;
};

class Layout {
public:
    explicit Layout(const Topology<AxisymmetricQ8>& topology);

    Structure structure() const;
    // shapes: of this model, which shape() made.
    Elements elements(const std::vector<double>& shapes) const;
    static std::vector<double> shapes(const Model<AxisymmetricQ8>& model);

    std::vector<Node> nodes;
    std::vector<int> rows;
    std::vector<int> entry_place;
    std::vector<int> strip_in_parent;
    std::vector<int> tile_in_parent;
    std::vector<int> column_in_parent;
    std::vector<int> inverse; // of every unknown: its place in the order of elimination
    std::vector<int> layer;
    std::vector<int> unknowns;
    std::vector<int> places;
    std::size_t first_row = 0; // of those that are not constant; some behind it may be
    std::vector<std::pair<std::size_t, std::size_t>> changing_entries; // first and one past the last
    std::size_t factor = 0;                                            // vectors
    std::size_t largest_stack[2] = {0, 0};
    std::size_t kept = 0;
    std::size_t most_rows = 0; // of a front, filled up
};

} // namespace pave::fe::lanes
