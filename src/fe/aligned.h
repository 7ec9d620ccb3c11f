// Memory that begins where a vector of any processor may.
#pragma once

#include <cstddef>
#include <new>

namespace pave::fe {

template <class T>
struct AlignedAllocator {
    using value_type = T;
    static constexpr std::align_val_t alignment{64};

    AlignedAllocator() = default;
    template <class Other>
    AlignedAllocator(const AlignedAllocator<Other>&) {}

    T* allocate(std::size_t count) { return static_cast<T*>(::operator new(count * sizeof(T), alignment)); }
    void deallocate(T* at, std::size_t) { ::operator delete(at, alignment); }
    bool operator==(const AlignedAllocator&) const = default;
};

} // namespace pave::fe
