#pragma once

#include <string>
#include <vector>

#include "capture/aravis_handles.h"
#include "capture/camera_options.h"

namespace chequer {

/// What a camera was set to.
struct AravisSetUp {
  double rate_hz = 0;                ///< frames a second; 0: as its trigger line says
  std::vector<std::string> remarks;  ///< what is not quite as asked, a sentence each
};

/// Sets a camera to the options, and reads back. Throws CameraNotReady where it does not answer, and std::runtime_error
/// naming what was asked, what exists and what to type where it cannot do it.
AravisSetUp SetUpAravis(ArvCamera* camera, const AravisOptions& options);

}  // namespace chequer
