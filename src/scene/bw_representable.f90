module bw_representable
  !! Products of inputs, formed in extended precision, that later work needs in double precision.
  use bw_kinds, only: dp, qp
  use bw_scene_messages, only: message_list
  implicit none (type, external)
  private
  public :: check_product, settle_product

contains

  pure subroutine settle_product(product, value, line, place, what, messages)
    !! Round a product to double precision; where it overflows or loses digits to underflow, say so.
    real(qp), intent(in) :: product
    real(dp), intent(out) :: value
    integer, intent(in) :: line
    character(*), intent(in) :: place, what
    type(message_list), intent(inout) :: messages
    integer :: before
    before = messages%count
    call check_product(product, line, place, what, messages)
    value = 0.0_dp
    if (messages%count == before) value = real(product, dp)
  end subroutine settle_product

  pure subroutine check_product(product, line, place, what, messages)
    !! The product is zero or a normal number of double precision.
    real(qp), intent(in) :: product
    integer, intent(in) :: line
    character(*), intent(in) :: place          !! an input that it depends on
    character(*), intent(in) :: what           !! what the product is
    type(message_list), intent(inout) :: messages
    if (abs(product) > huge(1.0_dp)) then
      call messages%add(line, place, what//' is too large for double precision; accepted: at most 1.79e308')
    else if (product /= 0.0_qp .and. abs(product) < tiny(1.0_dp)) then
      call messages%add(line, place, what//' is too small for double precision; accepted: at least 2.23e-308')
    end if
  end subroutine check_product

end module bw_representable
