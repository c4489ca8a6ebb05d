module bw_scene_variant
  !! A scene with something changed, for studies that run it in several ways. The inputs by name, from which it was
  !! built, stay as they are.
  use bw_kinds, only: dp
  use bw_missing, only: missing
  use bw_modes_par, only: modes_par, shown_modes
  use bw_scene, only: scene_type
  implicit none (type, external)
  private
  public :: with_tolerance, with_counts

contains

  pure type(scene_type) function with_tolerance(scene, tolerance) result(variant)
    !! Without spectral analysis, which no tolerance changes.
    type(scene_type), intent(in) :: scene
    real(dp), intent(in) :: tolerance         !! may be beyond the range of the input
    variant = scene
    if (allocated(variant%spectrum)) deallocate (variant%spectrum)
    variant%modes = modes_par(before=0, after=shown_modes, tolerance=tolerance)
  end function with_tolerance

  pure type(scene_type) function with_counts(scene, count) result(variant)
    !! The same number of modes before and after, without spectral analysis.
    type(scene_type), intent(in) :: scene
    integer, intent(in) :: count
    variant = scene
    if (allocated(variant%spectrum)) deallocate (variant%spectrum)
    variant%modes = modes_par(before=count, after=count, tolerance=missing)
  end function with_counts

end module bw_scene_variant
