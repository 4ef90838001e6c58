#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace chequer {

/// Rows of cells as lines, each column as wide as its widest cell, two spaces apart, none at the end of a line.
/// @param alignment '<' or '>' for each column; all rows have as many cells.
std::string Columns(const std::vector<std::vector<std::string>>& rows, std::string_view alignment);

/// Every line of a text cut to so many columns of a terminal. UTF-8: what takes several bytes takes one column.
std::string CutLines(const std::string& text, int columns);

}  // namespace chequer
