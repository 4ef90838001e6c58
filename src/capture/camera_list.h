#pragma once

#include <optional>
#include <string>
#include <vector>

namespace chequer {

/// A control or feature of a camera that is there.
struct ListedControl {
  std::string name;          ///< what to write in [capture.controls] or [capture.features]
  std::string allowed;       ///< "from 0 to 255, step 1", "0 (Off) or 1 (On)"; empty: it can only be read
  std::string value;         ///< now; empty where it cannot be read
  std::string initial;       ///< the driver's default; empty where it says none
  bool is_inactive = false;  ///< another control, mostly its automatic, governs it now
};

struct ListedSize {
  std::string size;              ///< "640x480", or "16x16 to 1920x1080"
  std::vector<double> rates_hz;  ///< falling; empty: unknown
};

struct ListedFormat {
  std::string name;    ///< what to write as pixel_format; empty: it cannot be used
  std::string native;  ///< as the driver calls it
  std::vector<ListedSize> sizes;
};

/// A camera that is there.
struct ListedCamera {
  std::string source;  ///< "v4l2" or "aravis"
  std::string device;  ///< what to write as device
  std::string name;
  std::string serial;
  std::vector<std::string> also;  ///< other names of it: links, address
  std::vector<ListedFormat> formats;
  std::vector<ListedControl> controls;
  std::string problem;  ///< why nothing more is known of it; empty where all is
};

/// All cameras of both kinds. Opens each for a moment; takes a second, in which the network is asked.
/// @param all_features of GenICam cameras; else the usual ones alone.
std::vector<ListedCamera> ListCameras(bool all_features);

/// Those of one kind.
std::vector<ListedCamera> ListV4l2Cameras();
std::vector<ListedCamera> ListAravisCameras(bool all_features);

}  // namespace chequer
