#include "search/neighbours.h"

#include <algorithm>
#include <cmath>
#include <nanoflann.hpp>

namespace explore::search {
namespace {

struct Cloud { // what nanoflann asks of one
    std::span<const std::vector<double>> points;
    std::size_t kdtree_get_point_count() const { return points.size(); }
    double kdtree_get_pt(std::size_t i, std::size_t k) const { return points[i][k]; }
    template <class Box>
    bool kdtree_get_bbox(Box&) const {
        return false;
    }
};

using KdTree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Cloud>, Cloud, -1, std::size_t>;

} // namespace

struct Neighbours::Tree {
    explicit Tree(std::span<const std::vector<double>> points)
        : cloud{points},
          index(points.empty() ? 0 : points[0].size(), cloud) {
        index.buildIndex();
    }
    Cloud cloud;
    KdTree index;
};

Neighbours::Neighbours(std::span<const std::vector<double>> points) : tree_(std::make_unique<Tree>(points)) {}
Neighbours::~Neighbours() = default;

std::vector<Neighbours::Neighbour> Neighbours::nearest(std::span<const double> unit, std::size_t count) const {
    count = std::min(count, tree_->cloud.points.size());
    std::vector<std::size_t> points(count);
    std::vector<double> squares(count);
    points.resize(count > 0 ? tree_->index.knnSearch(unit.data(), count, points.data(), squares.data()) : 0);
    std::vector<Neighbour> list;
    list.reserve(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        list.push_back({points[i], std::sqrt(squares[i])});
    }
    std::sort(list.begin(), list.end(), [](const Neighbour& a, const Neighbour& b) {
        return a.distance != b.distance ? a.distance < b.distance : a.point < b.point;
    });
    return list;
}

} // namespace explore::search
