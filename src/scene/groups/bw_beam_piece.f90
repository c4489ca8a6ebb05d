module bw_beam_piece
  !! A piece of a beam: its section, and the variation of the section along a tapering piece.
  !!
  !! All dimensions of a tapering section are linear in x, from 0 at the inner end to 1 at the outer end. So mass and stiffness
  !! are polynomials in x. Their coefficients are computed in extended precision from given values, so that none overflows.
  use bw_constants, only: qp_pi
  use bw_kinds, only: dp, qp
  use bw_missing, only: is_missing, missing
  implicit none (type, external)
  private
  public :: area_of, fibre_of, mass_law, mass_moments, piece_mass, rotary_law, second_moment_of, section_between, stiffness_law, &
    stretch_law

  type, public :: beam_piece
    !! A piece of one material and one section, or its section at one end.
    real(dp) :: length = 0.0_dp          !! l_i [m], > 0
    real(dp) :: density = 0.0_dp         !! ρ [kg/m³], > 0
    real(dp) :: youngs_modulus = 0.0_dp  !! E [Pa], > 0
    real(dp) :: diameter = missing       !! D of a solid circle [m]; `missing` for another section
    real(dp) :: area = 0.0_dp            !! A [m²], given, or πD²/4, or w h
    real(dp) :: second_moment = 0.0_dp   !! I [m⁴], given, or πD⁴/64, or w h³/12
    logical :: round = .false.           !! the diameter was given
    real(dp) :: width = missing          !! w of a solid rectangle [m]; `missing` for another section
    real(dp) :: height = missing         !! h of a solid rectangle [m], in the bending direction; likewise
    real(dp) :: extreme_fibre = missing  !! c, distance of the outermost fibre from the axis [m]; `missing` if not given
    logical :: is_lumped = .false.
      !! ρA and EI were given: they are stored as ρ and E, with A = 1 and I = 1
  end type beam_piece


contains

  elemental real(qp) function area_of(piece) result(area)
    !! Return A [m²] in extended precision, from given values.
    type(beam_piece), intent(in) :: piece
    area = piece%area
    if (piece%round) area = qp_pi/4*real(piece%diameter, qp)**2
    if (.not. is_missing(piece%width)) area = real(piece%width, qp)*piece%height
  end function area_of

  elemental real(qp) function second_moment_of(piece) result(second_moment)
    !! Return I [m⁴] in extended precision, from given values.
    type(beam_piece), intent(in) :: piece
    second_moment = piece%second_moment
    if (piece%round) second_moment = qp_pi/64*real(piece%diameter, qp)**4
    if (.not. is_missing(piece%width)) second_moment = piece%width*real(piece%height, qp)**3/12
  end function second_moment_of

  elemental real(qp) function piece_mass(piece)
    !! Return ρAl [kg] of a uniform piece.
    type(beam_piece), intent(in) :: piece
    piece_mass = real(piece%density, qp)*area_of(piece)*piece%length
  end function piece_mass

  elemental real(dp) function fibre_of(piece) result(fibre)
    !! Return c [m]: as given, D/2 of a circle, or h/2 of a rectangle; `missing` for any other section.
    type(beam_piece), intent(in) :: piece
    fibre = piece%extreme_fibre
    if (.not. is_missing(fibre)) return
    if (piece%round) fibre = 0.5_dp*piece%diameter
    if (.not. is_missing(piece%height)) fibre = 0.5_dp*piece%height
  end function fibre_of

  ! Tapering

  elemental type(beam_piece) function section_between(inner, outer, x) result(section)
    !! Return the section at a place of a tapering piece; its length is that of the piece.
    type(beam_piece), intent(in) :: inner, outer
    real(dp), intent(in) :: x                    !! from 0 to 1 over the piece
    section = inner
    section%density = at_x(inner%density, outer%density)
    section%youngs_modulus = at_x(inner%youngs_modulus, outer%youngs_modulus)
    section%diameter = at_x(inner%diameter, outer%diameter)
    section%width = at_x(inner%width, outer%width)
    section%height = at_x(inner%height, outer%height)
    section%extreme_fibre = at_x(inner%extreme_fibre, outer%extreme_fibre)
    section%area = at_x(inner%area, outer%area)
    section%second_moment = at_x(inner%second_moment, outer%second_moment)
    if (.not. (section%round .or. .not. is_missing(section%width))) return
    section%area = real(area_of(section), dp)
    section%second_moment = real(second_moment_of(section), dp)
  contains
    elemental real(dp) function at_x(a, b)
      real(dp), intent(in) :: a, b
      at_x = missing
      if (.not. is_missing(a)) at_x = a + x*(b - a)
    end function at_x
  end function section_between

  pure function mass_law(inner, outer) result(law)
    !! Return the coefficients of 1, x, x² … of ρA [kg/m], one only for a uniform piece. The next three functions do likewise.
    type(beam_piece), intent(in) :: inner, outer
    real(qp), allocatable :: law(:)
    law = trimmed(product_of(linear(inner%density, outer%density), area_law(inner, outer)))
  end function mass_law

  pure function stiffness_law(inner, outer) result(law)
    !! Return the coefficients of EI [N m²].
    type(beam_piece), intent(in) :: inner, outer
    real(qp), allocatable :: law(:)
    law = trimmed(product_of(linear(inner%youngs_modulus, outer%youngs_modulus), second_moment_law(inner, outer)))
  end function stiffness_law

  pure function stretch_law(inner, outer) result(law)
    !! Return the coefficients of EA [N].
    type(beam_piece), intent(in) :: inner, outer
    real(qp), allocatable :: law(:)
    law = trimmed(product_of(linear(inner%youngs_modulus, outer%youngs_modulus), area_law(inner, outer)))
  end function stretch_law

  pure function rotary_law(inner, outer) result(law)
    !! Return the coefficients of ρI [kg m].
    type(beam_piece), intent(in) :: inner, outer
    real(qp), allocatable :: law(:)
    law = trimmed(product_of(linear(inner%density, outer%density), second_moment_law(inner, outer)))
  end function rotary_law

  pure function mass_moments(inner, outer) result(moments)
    !! Return the mass of a piece [kg], and its first moment about the inner end [kg m].
    type(beam_piece), intent(in) :: inner, outer
    real(qp) :: moments(2)
    real(qp), allocatable :: law(:)
    integer :: k
    law = mass_law(inner, outer)
    moments = inner%length*[sum([(law(k)/k, k=1, size(law))]), inner%length*sum([(law(k)/(k + 1), k=1, size(law))])]
  end function mass_moments

  pure function area_law(inner, outer) result(law)
    type(beam_piece), intent(in) :: inner, outer
    real(qp), allocatable :: law(:)
    if (inner%round) then
      law = linear(inner%diameter, outer%diameter)
      law = qp_pi/4*product_of(law, law)
    else if (.not. is_missing(inner%width)) then
      law = product_of(linear(inner%width, outer%width), linear(inner%height, outer%height))
    else
      law = linear(inner%area, outer%area)
    end if
  end function area_law

  pure function second_moment_law(inner, outer) result(law)
    type(beam_piece), intent(in) :: inner, outer
    real(qp), allocatable :: law(:), side(:)
    if (inner%round) then
      side = linear(inner%diameter, outer%diameter)
      side = product_of(side, side)
      law = qp_pi/64*product_of(side, side)
    else if (.not. is_missing(inner%width)) then
      side = linear(inner%height, outer%height)
      law = product_of(linear(inner%width, outer%width), product_of(side, product_of(side, side)))/12
    else
      law = linear(inner%second_moment, outer%second_moment)
    end if
  end function second_moment_law

  pure function linear(inner, outer) result(law)
    real(dp), intent(in) :: inner, outer
    real(qp) :: law(2)
    law = [real(inner, qp), real(outer, qp) - inner]
  end function linear

  pure function product_of(a, b) result(law)
    real(qp), intent(in) :: a(:), b(:)
    real(qp) :: law(size(a) + size(b) - 1)
    integer :: i
    law = 0.0_qp
    do i = 1, size(a)
      law(i:i + size(b) - 1) = law(i:i + size(b) - 1) + a(i)*b
    end do
  end function product_of

  pure function trimmed(law) result(short)
    !! Drop trailing coefficients that are zero.
    real(qp), intent(in) :: law(:)
    real(qp), allocatable :: short(:)
    short = law(:max(1, findloc(law /= 0.0_qp, .true., dim=1, back=.true.)))
  end function trimmed

end module bw_beam_piece
