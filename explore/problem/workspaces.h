// The workspaces of a function that several threads compute with.
#pragma once

#include "problem/forward_function.h"

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace explore::problem {

// As many as there are evaluations at a time, however many threads take turns: they are lent, and do not belong to
// threads.
class Workspaces {
public:
    using Workspace = ForwardFunction::Workspace;

    // function: outlives this.
    explicit Workspaces(const ForwardFunction& function) : function_(&function) {}

    // use(workspace) with one that nobody else uses meanwhile. Throws what making a workspace and `use` do.
    template <class Use>
    auto lend(const Use& use) {
        struct Loan {
            Workspaces& all;
            std::unique_ptr<Workspace> workspace;
            ~Loan() { all.take_back(std::move(workspace)); }
        } const loan{*this, at_hand()};
        return use(*loan.workspace);
    }

private:
    std::unique_ptr<Workspace> at_hand() {
        {
            const std::scoped_lock lock(mutex_);
            if (!idle_.empty()) {
                auto workspace = std::move(idle_.back());
                idle_.pop_back();
                return workspace;
            }
        }
        return function_->make_workspace();
    }
    void take_back(std::unique_ptr<Workspace> workspace) {
        const std::scoped_lock lock(mutex_);
        idle_.push_back(std::move(workspace));
    }

    const ForwardFunction* function_;
    std::mutex mutex_;
    std::vector<std::unique_ptr<Workspace>> idle_;
};

} // namespace explore::problem
