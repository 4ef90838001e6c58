#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>

namespace chequer {

/// Memory for values that are written before they are read: unlike a vector's, they have no value at first, which
/// would cost as much as to fill them. With CHEQUER_SCRAMBLE, as the sanitizers have it, they are filled with what no
/// reader expects, so that tests tell of one who relies on them.
/// Like a vector, it keeps its memory when it gets smaller, or when an empty one is copied onto it.
template <class T>
class RawBuffer {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_default_constructible_v<T>);

 public:
  RawBuffer() = default;
  RawBuffer(const RawBuffer& other) { *this = other; }
  RawBuffer(RawBuffer&& other) noexcept { Swap(other); }
  RawBuffer& operator=(RawBuffer&& other) noexcept {
    Swap(other);
    return *this;
  }
  RawBuffer& operator=(const RawBuffer& other) {
    if (this == &other) return *this;
    Resize(other.size_);
    if (size_ > 0) std::memcpy(data(), other.data(), size_ * sizeof(T));
    return *this;
  }

  /// All values are undefined afterwards.
  void Resize(std::size_t size) {
    if (size > capacity_) {
      capacity_ = std::max(size, capacity_ + capacity_ / 2);
      // New memory is zero: vectors over a row's end read on, and what they make of it is thrown away, but not before
      // it has been compared. Of large pieces the system has zeros at hand, which nobody has to write.
      values_.reset(static_cast<T*>(std::calloc(capacity_, sizeof(T))));
      if (!values_) throw std::bad_alloc();
    }
    size_ = size;
#ifdef CHEQUER_SCRAMBLE
    static std::atomic<unsigned char> filling{0};
    if (size_ > 0) std::memset(values_.get(), filling += 37, size_ * sizeof(T));
#endif
  }

  std::size_t size() const { return size_; }
  T* data() { return values_.get(); }
  const T* data() const { return values_.get(); }
  T& operator[](std::size_t i) { return values_[i]; }
  const T& operator[](std::size_t i) const { return values_[i]; }
  T* begin() { return data(); }
  T* end() { return data() + size_; }
  const T* begin() const { return data(); }
  const T* end() const { return data() + size_; }

 private:
  void Swap(RawBuffer& other) {
    std::swap(values_, other.values_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
  }

  struct Free {
    void operator()(T* values) const { std::free(values); }
  };
  std::unique_ptr<T[], Free> values_;
  std::size_t size_ = 0, capacity_ = 0;
};

/// A table of floats by columns, which vectors read. Keeps its memory.
class FloatColumns {
 public:
  /// Vectors may run so far over the end of a column.
  static constexpr std::size_t kBeyond = 64;

  /// Values are undefined afterwards.
  void Resize(std::size_t columns, std::size_t rows) {
    stride_ = rows + kBeyond;
    values_.Resize(columns * stride_);
  }
  float* column(std::size_t k) { return values_.data() + k * stride_; }
  const float* column(std::size_t k) const { return values_.data() + k * stride_; }

 private:
  std::size_t stride_ = 0;
  RawBuffer<float> values_;
};

}  // namespace chequer
