module bw_mode_notes
  !! What there is to say of the modes of a case, beside their numbers.
  use bw_kinds, only: dp
  use bw_beam_units, only: beam_units
  use bw_damping, only: law_of
  use bw_damping_par, only: by_ratio
  use bw_galerkin_set, only: galerkin_set
  use bw_mode_set, only: mode_set
  use bw_scene, only: scene_type
  use bw_scene_operator, only: axial_strain
  use bw_text, only: append, shortest, string, text_of
  implicit none (type, external)
  private
  public :: note_coupling, note_growth, note_no_effect, note_strain, note_unresolved

contains

  subroutine note_coupling(scene, units, modes, notes)
    !! Rayleigh's damping is diagonal in modes of the elastic stiffness alone, which tension and rotation change.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    class(mode_set), intent(in) :: modes           !! in force after t = 0
    type(string), allocatable, intent(inout) :: notes(:)
    real(dp), parameter :: nothing = 1.0e-9_dp     ! rounding of modes that are orthogonal
    real(dp) :: ratio
    if (.not. allocated(scene%damping)) return
    if (by_ratio(scene%damping)) return
    select type (modes)
    type is (galerkin_set)
      ratio = modes%coupling(law_of(scene%damping, units))
      if (ratio > nothing) call append(notes, 'coupled damping: Rayleigh''s damping couples these modes and is taken '// &
        'without that: at most '//shortest(ratio, 2)//' of what it takes from the modes themselves')
    end select
  end subroutine note_coupling

  subroutine note_growth(units, modes, notes)
    !! Which modes grow.
    type(beam_units), intent(in) :: units
    class(mode_set), intent(in) :: modes           !! in force after t = 0
    type(string), allocatable, intent(inout) :: notes(:)
    integer :: growing
    growing = count(modes%beta_squared%hi < 0.0_dp)
    if (growing == 0) return
    call append(notes, 'unstable: '//text_of(growing)//' of '//text_of(modes%count)// &
      ' modes grow without bound, the angular velocity being above '// &
      shortest(modes%critical_speed%hi*units%frequency, 6)//' rad/s')
  end subroutine note_growth

  subroutine note_no_effect(notes)
    !! Rotation acts on nothing.
    type(string), allocatable, intent(inout) :: notes(:)
    call append(notes, 'no effect: rotation out of plane changes nothing in this model, which has neither tension nor shear')
  end subroutine note_no_effect

  subroutine note_strain(scene, units, notes)
    !! Where rotation strains the beam beyond what linear theory holds for.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    type(string), allocatable, intent(inout) :: notes(:)
    real(dp), parameter :: most = 0.1_dp
    if (axial_strain(scene, units) <= most) return
    call append(notes, 'outside linear theory: omega l/h sqrt(I/A) is '// &
      shortest(axial_strain(scene, units), 3)//', above 0.1: rotation strains the beam by more than half a per cent')
  end subroutine note_strain

  subroutine note_unresolved(notes)
    !! The modes of one of the beams, or of both, are not to be trusted.
    type(string), allocatable, intent(inout) :: notes(:)
    call append(notes, &
      'not converged: the polynomials of the Galerkin basis do not resolve the modes; every number of the case is fill')
  end subroutine note_unresolved

end module bw_mode_notes
