#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "core/printable.h"

namespace chequer {

/// In the order in which things are put in: it is read by people too.
using Json = nlohmann::ordered_json;

/// Zeros lose their sign: -0.0 is no other place than 0.0, and reads as if it were.
inline void PlainZeros(Json& json) {
  if (json.is_structured())
    for (Json& each : json) PlainZeros(each);
  else if (json.is_number_float() && json.get<double>() == 0)
    json = 0.0;
}

inline std::string Dump(Json json) {
  PlainZeros(json);
  // Names come from other programs, files have names of their own: any bytes; JSON may not hold those, and a terminal
  // obeys some that it may.
  return PrintableJson(json.dump(-1, ' ', false, Json::error_handler_t::replace));
}

/// The upper triangle of a symmetric matrix, row by row.
template <typename Matrix>
Json UpperTriangle(const Matrix& covariance) {
  Json numbers = Json::array();
  for (int row = 0; row < covariance.rows(); ++row)
    for (int col = row; col < covariance.cols(); ++col) numbers.push_back(covariance(row, col));
  return numbers;
}

template <typename Time>
std::int64_t Microseconds(Time time) {
  return time.time_since_epoch().count();
}

}  // namespace chequer
