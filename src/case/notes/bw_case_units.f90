module bw_case_units
  !! Warnings of likely slips of units: numbers that no machine part has, and the slip that would explain them. Four
  !! tests: speed of sound √(E/ρ) and density against the range of solids; the size of the beam; masses over the beam's;
  !! and the duration of the record over the first period.
  use bw_beam_par, only: beam_mass, beam_piece, pieces_of_beam
  use bw_beam_units, only: beam_units
  use bw_constants, only: two_pi
  use bw_kinds, only: dp
  use bw_mode_set, only: mode_set
  use bw_scene, only: scene_type
  use bw_text, only: append, shortest, string, text_of
  implicit none (type, external)
  private
  public :: note_units

  type :: number_span
    real(dp) :: low, high
  end type number_span

  type(number_span), parameter :: sound = number_span(100.0_dp, 20000.0_dp)     !! √(E/ρ), m/s: soft rubber to diamond
  type(number_span), parameter :: density = number_span(1.0_dp, 23000.0_dp)     !! ρ, kg/m³: aerogel to osmium
  type(number_span), parameter :: usual_sound = number_span(300.0_dp, 20000.0_dp), usual_density = number_span(100.0_dp, 23000.0_dp)
    !! without rubber and foam: range for numbers in a guessed unit
  real(dp), parameter :: longest = 200.0_dp         !! m: a rotor blade of 2025 has 150
  real(dp), parameter :: heaviest = 1.0e6_dp        !! kg: rotors of large generators have a third of it
  real(dp), parameter :: largest_ratio = 100.0_dp   !! of a mass to the beam's, beyond which the beam is a mere spring
  real(dp), parameter :: least_part = 1.0e-4_dp     !! of the period of the first bending mode

  type :: unit_slip
    real(dp) :: factor = 1.0_dp                     !! that the number lacks
    character(32) :: words = ''                     !! name and likely unit
  end type unit_slip

  type(unit_slip), parameter :: modulus_slips(*) = [unit_slip(), unit_slip(1.0e9_dp, 'youngs_modulus in GPa'), &
                                                    unit_slip(1.0e6_dp, 'youngs_modulus in MPa')]
  type(unit_slip), parameter :: density_slips(*) = [unit_slip(), unit_slip(1.0e3_dp, 'density in g/cm3'), &
    unit_slip(1.0e12_dp, 'density in t/mm3'), unit_slip(1.0e9_dp, 'density in kg/mm3'), unit_slip(1.0e-3_dp, 'density in g/m3')]

contains

  subroutine note_units(scene, units, modes, notes)
    !! Warn of likely slips of units.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    class(mode_set), intent(in) :: modes           !! after t = 0, or the first of them
    type(string), allocatable, intent(inout) :: notes(:)
    integer :: b
    if (.not. scene%beam%is_lumped) call note_material(pieces_of_beam(scene%beam), notes)
    if (scene%beam%length > longest .or. beam_mass(scene%beam) > heaviest) call append(notes, &
      'large beam: '//shortest(scene%beam%length, 6)//' m long, of a mass of '//shortest(real(beam_mass(scene%beam), dp), 3)// &
      ' kg. Are length and section in m, not in mm?')
    if (allocated(scene%bodies)) then
      do b = 1, size(scene%bodies)
        if (scene%bodies(b)%mass_given) call note_mass(scene%bodies(b)%mass, units, 'body', notes)
        call note_inertia(scene%bodies(b)%rotary_inertia, units, 'body', notes)
      end do
    end if
    if (allocated(scene%impact)) then
      if (scene%impact%mass_given) call note_mass(scene%impact%mass, units, 'impact', notes)
    end if
    if (allocated(scene%capture)) call note_inertia(scene%capture%rotary_inertia, units, 'capture', notes)
    if (allocated(scene%response)) call note_record(scene%response%duration, units, modes, notes)
  end subroutine note_units

  pure subroutine note_material(pieces, notes)
    !! Warn of the first piece outside the range of solids, and count the others.
    type(beam_piece), intent(in) :: pieces(:)
    type(string), allocatable, intent(inout) :: notes(:)
    logical :: strange(size(pieces))
    character(:), allocatable :: place, others
    integer :: i
    strange = .not. (lies_in(sound_of(pieces), sound) .and. lies_in(pieces%density, density))
    i = findloc(strange, .true., dim=1)
    if (i == 0) return
    place = ''
    others = ''
    if (size(pieces) > 1) place = ' of piece '//text_of(i)
    if (count(strange) > 1) others = ' (that of '//text_of(count(strange) - 1)//' more of the pieces too)'
    call append(notes, 'material'//place//': sqrt(E/rho), the speed of sound in it, is '//shortest(sound_of(pieces(i)), 3)// &
                ' m/s, and its density '//shortest(pieces(i)%density, 3)//' kg/m3; solids have 100 to 20000 m/s and 1 to '// &
                '23000 kg/m3'//others//'. '//likely_slip(pieces(i)))
  end subroutine note_material

  pure function likely_slip(piece) result(words)
    !! Return the fewest slips that bring a material into the usual range, in words; else a question.
    type(beam_piece), intent(in) :: piece
    character(:), allocatable :: words
    type(beam_piece) :: meant
    integer :: e, r, changes
    words = 'Is youngs_modulus in Pa, and density in kg/m3?'
    do changes = 1, 2
      do e = 1, size(modulus_slips)
        do r = 1, size(density_slips)
          if (count([e, r] > 1) /= changes) cycle
          meant = piece
          meant%youngs_modulus = piece%youngs_modulus*modulus_slips(e)%factor
          meant%density = piece%density*density_slips(r)%factor
          if (.not. (lies_in(sound_of(meant), usual_sound) .and. lies_in(meant%density, usual_density))) cycle
          words = trim(modulus_slips(e)%words)
          if (changes == 2) words = words//' and '
          words = 'It looks like '//words//trim(density_slips(r)%words)
          return
        end do
      end do
    end do
  end function likely_slip

  elemental real(dp) function sound_of(piece) result(speed)
    !! √(E/ρ), m/s.
    type(beam_piece), intent(in) :: piece
    speed = sqrt(piece%youngs_modulus)/sqrt(piece%density)
  end function sound_of

  elemental logical function lies_in(value, span)
    real(dp), intent(in) :: value
    type(number_span), intent(in) :: span
    lies_in = value >= span%low .and. value <= span%high
  end function lies_in

  pure subroutine note_mass(mass, units, group, notes)
    !! Warn of a mass in kg that makes the beam a mere spring.
    real(dp), intent(in) :: mass                   !! kg
    type(beam_units), intent(in) :: units
    character(*), intent(in) :: group              !! group of the mass
    type(string), allocatable, intent(inout) :: notes(:)
    if (mass > largest_ratio*units%mass) call append(notes, 'heavy mass: that of &'//group//', '//shortest(mass, 6)//' kg, is '// &
      shortest(mass/units%mass, 3)//' times the beam''s. Is it in kg, not in g, and are length and section of the beam in m?')
  end subroutine note_mass

  pure subroutine note_inertia(inertia, units, group, notes)
    !! Warn likewise of a rotary inertia.
    real(dp), intent(in) :: inertia                !! kg m²
    type(beam_units), intent(in) :: units
    character(*), intent(in) :: group
    type(string), allocatable, intent(inout) :: notes(:)
    real(dp) :: ratio
    ratio = inertia/units%mass/units%length/units%length
    if (ratio > largest_ratio) call append(notes, 'large inertia: that of &'//group//', '//shortest(inertia, 6)//' kg m2, is '// &
      shortest(ratio, 3)//' times mass times length squared of the beam. Is it in kg m2, not in kg mm2?')
  end subroutine note_inertia

  pure subroutine note_record(duration, units, modes, notes)
    !! Warn of a record much shorter than the first period of bending.
    real(dp), intent(in) :: duration               !! s
    type(beam_units), intent(in) :: units
    class(mode_set), intent(in) :: modes
    type(string), allocatable, intent(inout) :: notes(:)
    real(dp) :: period                             ! s
    integer :: k
    k = count(modes%rigid()) + 1
    if (k > modes%count) return
    if (modes%beta_squared(k)%hi <= 0.0_dp) return
    period = two_pi/sqrt(modes%beta_squared(k)%hi)*units%time%hi
    if (duration < least_part*period) call append(notes, 'short record: '//shortest(duration, 3)//' s are '// &
      shortest(duration/period, 2)//' of the period of mode '//text_of(k)//', '//shortest(period, 3)// &
      ' s. Is duration in s, are lengths in m and youngs_modulus in Pa?')
  end subroutine note_record

end module bw_case_units
