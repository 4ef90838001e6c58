#pragma once

#include <optional>

#include "chequer/detector.h"
#include "detect/fit/linear_bend.h"
#include "detect/pose/plane_pose.h"

namespace chequer {

/// What is measured of a board whose paper may bend, by too little to tell for sure: the mean of what it is on flat and
/// on bent paper, each as likely as the image has it (Hoeting et al., "Bayesian model averaging", 1999), with what they
/// differ by in its covariance. A bend moves a board's pose by several times as much as the corners tell of it.
/// Nothing where the paper is as good as flat. @param pose of the board on flat paper.
std::optional<BoardMeasurement> AllowForBend(const BendEvidence& evidence, const BoardMeasurement& flat,
                                             const PlanePose& pose);

}  // namespace chequer
