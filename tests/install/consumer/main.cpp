// Draws a marker, finds it, and compares with what was drawn.
#include <chequer/camera_file.h>
#include <chequer/detector.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

namespace {

constexpr int kImageSide = 240;
constexpr int kCellSide = 24;
constexpr int kFirst = 48;  // left and top edge of the marker, pixels
constexpr std::uint64_t kId = 1234;

void SetPixel(std::vector<std::uint8_t>& bgr, int x, int y, char colour) {
  std::uint8_t* pixel = &bgr[static_cast<std::size_t>(3 * (y * kImageSide + x))];
  pixel[0] = colour == 'K' || colour == 'Y' ? 20 : 220;
  pixel[1] = colour == 'K' || colour == 'B' ? 20 : 220;
  pixel[2] = pixel[1];
}

std::vector<std::uint8_t> DrawMarker(const chequer::MarkerCode& code) {
  std::vector<std::uint8_t> bgr(std::size_t{3} * kImageSide * kImageSide, 128);
  const std::string colours = chequer::CellColours(code.size(), code.Encode(kId));
  const int side = code.size().cols * kCellSide;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const int cell = y / kCellSide * code.size().cols + x / kCellSide;
      SetPixel(bgr, kFirst + x, kFirst + y, colours[static_cast<std::size_t>(cell)]);
    }
  return bgr;
}

}  // namespace

int main() {
  chequer::DetectorOptions options;
  options.families[0].side_m = 0.12;
  options.camera = chequer::ParseCamera(
      "[camera]\nwidth = 240\nheight = 240\nfx = 240.0\nfy = 240.0\ncx = 119.5\ncy = 119.5\nmodel = \"pinhole\"\n"
      "distortion = []\n",
      "built in");
  const std::vector<std::uint8_t> bgr = DrawMarker(options.families[0].code);
  chequer::Detector detector(options);
  const auto image = chequer::ViewPacked(chequer::PixelFormat::kBgr8, kImageSide, kImageSide, bgr);
  const auto markers = detector.Detect(*image);
  if (markers.size() != 1 || markers[0].id != kId) {
    std::printf("expected the marker %llu, found %zu markers\n", static_cast<unsigned long long>(kId), markers.size());
    return 1;
  }
  // 144 pixels of 240 per unit of slope: 0.12 m are seen so large from 0.2 m.
  const auto& position = markers[0].camera_from_marker.translation;
  std::printf("marker %llu at (%.4f, %.4f, %.4f) m\n", static_cast<unsigned long long>(*markers[0].id), position.x(),
              position.y(), position.z());
  return (position - Eigen::Vector3d(0, 0, 0.2)).norm() < 1e-3 ? 0 : 1;
}
