#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "print/sheet.h"

namespace chequer {

/// A file to be written.
struct PrintedFile {
  std::string suffix;  ///< to be put before the extension: empty, or "-1", "-2", … where there is a file a page
  std::vector<std::uint8_t> bytes;
};

/// The sheet as one PDF, a page a page, in true size.
PrintedFile DrawPdf(const SheetOptions& options, const SheetLayout& layout);

/// The sheet as SVG, a file a page, in true size.
std::vector<PrintedFile> DrawSvg(const SheetOptions& options, const SheetLayout& layout);

/// The sheet as PNG, a file a page, which says how large a pixel is. Throws std::runtime_error where a page has more
/// pixels than fit.
std::vector<PrintedFile> DrawPng(const SheetOptions& options, const SheetLayout& layout, double dots_per_inch);

}  // namespace chequer
