// The chair's body meets people: when, where on its outline, and which of the two came.
#pragma once

#include <span>
#include <vector>

#include "lfdcore/simulation/differential_drive.hpp"
#include "lfdcore/simulation/people.hpp"

namespace lfdcore {

/// A corner belongs to the nose or the rear.
enum class OutlinePart { nose, left, right, rear };

/// What was so when a contact began: the first of the motors' periods at whose end disc and outline share a point.
struct PersonContact {
  int person = 0;                        ///< its place among the people
  double stamp = 0;                      ///< since the reset [s]
  Pose2 pose;                            ///< of the chair, T_map_base
  Twist2 twist;                          ///< of its wheels
  Eigen::Vector2d position{0, 0};        ///< of the person in map [m]
  Eigen::Vector2d velocity{0, 0};        ///< of the person in map [m/s]
  Eigen::Vector2d point{0, 0};           ///< of the outline that is nearest to the person's centre, in base_link [m]
  OutlinePart part = OutlinePart::nose;  ///< where that point is
  double chair_approach = 0;             ///< speed of the outline there towards the person [m/s]
  double person_approach = 0;            ///< the person's speed towards the outline there [m/s]
  double chair_approach_since = 0;       ///< the largest while they touch, until the person's centre is inside [m/s]
};

/// Neither stops the other: a person does not give way to the chair and is no wall, so the two may overlap. A contact
/// is over when the disc has been clear of the outline by the chair's release_gap for its release_time.
class PersonContacts {
 public:
  /// Looks at the chair and the people `duration` [s] after the last time.
  void note(double stamp, const Pose2& pose, const Twist2& twist, const ChairConfig& chair,
            std::span<const Person> people, double duration);

  /// In the order in which they began.
  const std::vector<PersonContact>& all() const { return all_; }
  /// Whether any contact is not yet over.
  bool touching() const;

 private:
  struct Touch {
    int contact = -1;  // its place in all_; -1: none
    double clear_time = 0;
  };

  std::vector<PersonContact> all_;
  std::vector<Touch> touches_;  // of each person
};

}  // namespace lfdcore
