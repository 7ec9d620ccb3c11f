// The nearest points of a cloud in the unit cube.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace explore::search {

class Neighbours {
public:
    // points: all of one dimension; they must outlive this and stay where they are. Cost: points log points.
    explicit Neighbours(std::span<const std::vector<double>> points);
    ~Neighbours();

    struct Neighbour {
        std::size_t point = 0; // its index
        double distance = 0.0; // Euclid
    };
    // The `count` nearest to `unit` (fewer where there are not so many), nearest first; a point of the cloud is its own
    // nearest. May be called from any thread.
    std::vector<Neighbour> nearest(std::span<const double> unit, std::size_t count) const;

private:
    struct Tree;
    std::unique_ptr<Tree> tree_;
};

} // namespace explore::search
