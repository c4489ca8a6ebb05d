module bw_mode_notes
  !! What there is to say of the modes of a case, beside their numbers.
  use bw_kinds, only: dp
  use bw_case_result, only: case_result, add_note, case_done, case_not_converged
  use bw_damping, only: law_of
  use bw_damping_par, only: by_ratio
  use bw_galerkin_set, only: galerkin_set
  use bw_scene, only: scene_type
  use bw_beam_operator, only: axial_strain
  use bw_text, only: shortest
  implicit none (type, external)
  private
  public :: note_coupling, note_no_effect, note_strain, note_unresolved

contains

  subroutine note_coupling(scene, result)
    !! Rayleigh's damping is diagonal in modes of the elastic stiffness alone, which tension and rotation change.
    type(scene_type), intent(in) :: scene
    type(case_result), intent(inout) :: result
    real(dp), parameter :: nothing = 1.0e-9_dp     ! rounding of modes that are orthogonal
    real(dp) :: ratio
    if (.not. allocated(scene%damping)) return
    if (by_ratio(scene%damping)) return
    select type (modes => result%modes)
    type is (galerkin_set)
      ratio = modes%coupling(law_of(scene%damping, result%units))
      if (ratio > nothing) call add_note(result, 'coupled damping: Rayleigh''s damping couples these modes and is taken '// &
        'without that: at most '//shortest(ratio, 2)//' of what it takes from the modes themselves')
    end select
  end subroutine note_coupling

  subroutine note_no_effect(result)
    type(case_result), intent(inout) :: result
    call add_note(result, &
      'no effect: rotation out of plane changes nothing in this model, which has neither tension nor shear')
  end subroutine note_no_effect

  subroutine note_strain(scene, result)
    !! Where rotation strains the beam beyond what linear theory holds for.
    type(scene_type), intent(in) :: scene
    type(case_result), intent(inout) :: result
    real(dp), parameter :: most = 0.1_dp
    if (axial_strain(scene, result%units) <= most) return
    call add_note(result, 'outside linear theory: omega l/h sqrt(I/A) is '// &
      shortest(axial_strain(scene, result%units), 3)//', above 0.1: rotation strains the beam by more than half a per cent')
  end subroutine note_strain

  subroutine note_unresolved(result)
    type(case_result), intent(inout) :: result
    if (result%status == case_done) call add_note(result, &
      'not converged: the polynomials of the Galerkin basis do not resolve the modes; every number of the case is fill')
    result%status = case_not_converged
  end subroutine note_unresolved

end module bw_mode_notes
