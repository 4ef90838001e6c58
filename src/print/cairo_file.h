#pragma once

#include <cairo.h>

#include <memory>

namespace chequer {

struct FreeCairoSurface {
  void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
};
/// What cairo draws on.
using CairoSurface = std::unique_ptr<cairo_surface_t, FreeCairoSurface>;

struct FreeCairo {
  void operator()(cairo_t* cairo) const { cairo_destroy(cairo); }
};
/// What draws.
using Cairo = std::unique_ptr<cairo_t, FreeCairo>;

/// For cairo to write a file with. @param bytes a std::vector<std::uint8_t>, to which the data is added.
cairo_status_t AppendToBytes(void* bytes, const unsigned char* data, unsigned length);

/// Throws std::runtime_error with cairo's words where drawing failed.
void CheckCairo(cairo_status_t status);

}  // namespace chequer
