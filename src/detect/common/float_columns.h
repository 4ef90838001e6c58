#pragma once

#include <cstddef>

#include "detect/common/raw_buffer.h"

namespace chequer {

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
